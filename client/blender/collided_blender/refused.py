"""What a user is told."""


class Refused(Exception):
    """Something that cannot be done, and why."""

    def __init__(self, message):
        super().__init__(message)
        self.message = message
