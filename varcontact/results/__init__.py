"""Results: solutions, histories, stresses, reports."""
