"""What the user says: frozen dataclasses that check themselves."""
