"""The same problem in other codes, as their users would write it."""
