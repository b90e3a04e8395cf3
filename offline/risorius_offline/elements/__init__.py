"""Element types, by their name in meshio. A new one is one file here and one line in `ELEMENTS`."""

from risorius_offline.elements.hex8 import HEX8
from risorius_offline.elements.reference import ReferenceElement
from risorius_offline.elements.tet4 import TET4
from risorius_offline.elements.tet10 import TET10
from risorius_offline.elements.wedge6 import WEDGE6

ELEMENTS: dict[str, ReferenceElement] = {element.cell_type: element for element in (HEX8, WEDGE6, TET4, TET10)}

__all__ = ["ELEMENTS", "HEX8", "TET4", "TET10", "WEDGE6", "ReferenceElement"]
