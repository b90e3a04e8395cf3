"""Terms of the energy besides tissue and active stress, one a file. A scene takes those it calls for."""

from risorius_offline.effects.dead_load import DeadLoad
from risorius_offline.effects.effect import NO_CONTACTS, Effect, NodeBlocks

__all__ = ["NO_CONTACTS", "DeadLoad", "Effect", "NodeBlocks"]
