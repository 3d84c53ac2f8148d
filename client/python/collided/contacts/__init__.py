"""Contacts of a frame."""

from collided.contacts.contacts import Contacts, Flag
from collided.contacts.closest import Feature, OnEdge, OnTriangle
from collided.contacts.pairs import MeshPair, MeshPairs, PairState

__all__ = ["Contacts", "Feature", "Flag", "MeshPair", "MeshPairs", "OnEdge", "OnTriangle", "PairState"]
