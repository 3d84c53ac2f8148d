"""Contacts of a frame."""

from collided.contacts.contacts import Contacts, Flag

__all__ = ["Contacts", "Flag"]
