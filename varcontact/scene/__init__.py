"""The scene of a user: frozen dataclasses that check themselves."""
