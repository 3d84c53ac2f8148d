"""Contacts of a frame."""

from collided.contacts.contacts import Contacts, Flag
from collided.contacts.closest import Feature, OnEdge, OnTriangle

__all__ = ["Contacts", "Feature", "Flag", "OnEdge", "OnTriangle"]
