"""What a scene requires, and why: methods, elements, memory."""
