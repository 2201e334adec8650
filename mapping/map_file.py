"""map.json: GeoJSON of a soil map, written and read."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.importing.local_frame import latitude_longitude
from softsoil.mapping.cells import Cell
from softsoil.mapping.soil_map import SoilMap
from softsoil.symbolic.soil import CLASS_NUMBERS, Soil

DECIMALS = 8
"""Of degrees: a millimetre."""


def as_json(ground: SoilMap, soil: Soil, law: str) -> dict[str, Any]:
    """The content of map.json: GeoJSON in longitude and latitude, or in metres of the logs' own frame where that is not known.

    ground: the map; soil, law: that its n belongs to.
    """
    size, origin, features = ground.size, ground.origin, []
    for c in ground.cells:
        x, y = c.column * size, c.row * size
        ring = np.array([[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]], dtype=float)
        if origin is not None:
            latitude, longitude = latitude_longitude("map", ring[:, 0], ring[:, 1], origin)
            ring = np.column_stack([longitude, latitude]).round(DECIMALS)
        geometry = {"type": "Polygon", "coordinates": [ring.tolist()]}
        features.append({"type": "Feature", "geometry": geometry, "properties": asdict(c)})
    logs = [
        {
            "log": one.log, "verdict": one.verdict and one.verdict.word, "reason": one.verdict and one.verdict.reason,
            "covered": one.covered, "blocked": dict(one.blocked),
            "used": not one.left_out, "left_out": one.left_out or None, "notes": list(one.notes),
            "common": None if one.left_out else one.common,
        }
        for one in ground.drives
    ]  # fmt: skip
    frame = "local, m" if origin is None else "WGS 84 longitude and latitude, deg"
    about = {"name": soil.name, **{name: getattr(soil, name) for name in CLASS_NUMBERS}}
    place = {"frame": frame, "origin": origin and list(origin), "cell_m": size, "driven": ground.driven}
    return {"type": "FeatureCollection", **place, "soil": about, "law": law, "logs": logs, "features": features}


def load_map(path: str | Path) -> SoilMap:
    """The map that `softsoil map` wrote: map.json, without its drives.

    Raises ValueError for a file that is not one, naming it.

    Example:
        >>> import softsoil
        >>> softsoil.load_map("nothing.json")
        Traceback (most recent call last):
        ...
        ValueError: nothing.json: expected a file of softsoil map, found none
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"{path}: expected a file of softsoil map, found none")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        names = tuple(Cell.__dataclass_fields__)
        cells = tuple(Cell(**{name: one["properties"][name] for name in names}) for one in content["features"])
        origin = content["origin"] and tuple(content["origin"])
        return SoilMap(float(content["cell_m"]), cells, origin, driven=int(content.get("driven", 0)))
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: expected a file of softsoil map, found another ({error!r})") from None
