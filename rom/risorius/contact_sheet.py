"""Contact sheets: many labelled pictures of a face in one, each face from the front and in three-quarter view."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from risorius.companion import posed_companions
from risorius.errors import MissingExtraError
from risorius.picture import draw_faces
from risorius.sheets import Face

if TYPE_CHECKING:
    from risorius.engine import Engine

VIEWS = ("front", "three-quarter")
COLUMNS = 5  # most faces side by side

_PAPER, _INK = (194, 199, 204), (40, 42, 46)  # the paper is the pictures' own background at their lower edge
_LABEL = 0.08  # height of a label as share of a picture's


def draw_sheet(engine: Engine, faces: Sequence[Face], size: tuple[int, int] = (240, 280)) -> npt.NDArray[np.uint8]:
    """Return a picture (height, width, 3) of labelled faces; all share one camera for each view.

    size: (width, height) of each single picture, pixels. Raises what `Engine.evaluate` and `draw_faces` raise.
    """
    frames = [engine.evaluate(face.weights, muscles=face.muscles) for face in faces]
    model = engine.model
    return arrange(
        draw_faces(
            [frame.vertices for frame in frames],
            engine.triangles,
            views=VIEWS,
            size=size,
            colours=model.colours,
            companions=[posed_companions(model.companions, model.poses, frame.coordinates) for frame in frames],
        ),
        [face.label for face in faces],
    )


def arrange(pictures: Sequence[Sequence[npt.NDArray[np.uint8]]], labels: Sequence[str]) -> npt.NDArray[np.uint8]:
    """Return one picture of pictures of faces, each from several views side by side with its label beneath."""
    cells = [_labelled(np.concatenate(row, axis=1), label) for row, label in zip(pictures, labels, strict=True)]
    columns = math.ceil(len(cells) / math.ceil(len(cells) / COLUMNS))  # as many in every row as can be
    blank = np.full_like(cells[0], _PAPER)
    cells += [blank] * (-len(cells) % columns)
    rows = [np.concatenate(cells[start : start + columns], axis=1) for start in range(0, len(cells), columns)]
    return np.concatenate(rows)


def _labelled(picture: npt.NDArray[np.uint8], label: str) -> npt.NDArray[np.uint8]:
    """Put a strip with a label under a picture."""
    try:
        from PIL import Image, ImageDraw, ImageFont
    except ModuleNotFoundError as error:
        raise MissingExtraError("labelling a picture", "view", "pillow") from error
    height, width, _ = picture.shape
    strip = Image.new("RGB", (width, round(_LABEL * height)), _PAPER)
    middle, font = (width / 2, strip.height / 2), ImageFont.load_default(0.7 * strip.height)
    ImageDraw.Draw(strip).text(middle, label, fill=_INK, font=font, anchor="mm")
    return np.concatenate([picture, np.asarray(strip)])
