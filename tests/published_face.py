"""Where the published face is, which tests read and never copy."""

import os
from pathlib import Path


def published_face_folder() -> Path:
    """Folder of the ArtiSynth face, if it is there."""
    root = Path(os.environ.get("RISORIUS_ANATOMY_DIR", Path(__file__).parents[2] / "shared" / "anatomy"))
    return root / "artisynth_face"
