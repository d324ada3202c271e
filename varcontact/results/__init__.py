"""What comes out: solutions, histories, stresses, reports."""
