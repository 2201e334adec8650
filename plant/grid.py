"""Sparse height field: what the soil remembers, in tiles that exist only where a wheel has touched.

A tile is 8 x 8 nodes. An open-addressing hash finds it from (layer, tile row, tile column); memory grows with the rut
and the cost of finding a node does not depend on how long the rut is. A layer is one memory of the soil: all wheels
share layer 0 unless the passes are kept separate.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.kernel import inner, kernel

TILE = 8
TILE_NODES = TILE * TILE
SINKAGE, PLASTIC, YIELD, SHEAR = range(4)
"""Columns of a node's memory: sinkage at the last touch (m), plastic sinkage (m), yield pressure (Pa), shear path
(m)."""

_OFFSET = 1 << 28
_EMPTY = np.int64(-1)


@kernel
def tile_key(layer, row, column):
    """One integer per (layer, tile row, tile column); rows and columns within +-2^28 tiles."""
    return (np.int64(layer) << 58) | ((np.int64(row) + _OFFSET) << 29) | (np.int64(column) + _OFFSET)


@inner
def _start(key, size):
    """Where the search for a key begins: a multiplicative hash (size is a power of two)."""
    h = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
    return np.int64((h >> np.uint64(20)) & np.uint64(size - 1))


@kernel
def find_tile(keys, slots, key):
    """Slot of the tile, or -1 where the soil is untouched."""
    size = keys.shape[0]
    i = _start(key, size)
    while keys[i] != -1:
        if keys[i] == key:
            return slots[i]
        i = (i + 1) & (size - 1)
    return -1


@kernel
def add_tile(keys, slots, count, key):
    """Slot of a new, fresh tile. The caller keeps room: see `RutGrid.reserve`."""
    size = keys.shape[0]
    i = _start(key, size)
    while keys[i] != -1:
        i = (i + 1) & (size - 1)
    keys[i] = key
    slots[i] = count[0]
    count[0] += 1
    return slots[i]


@kernel
def _rehash(old_keys, old_slots, keys, slots):
    for i in range(old_keys.shape[0]):
        if old_keys[i] != -1:
            j = _start(old_keys[i], keys.shape[0])
            while keys[j] != -1:
                j = (j + 1) & (keys.shape[0] - 1)
            keys[j] = old_keys[i]
            slots[j] = old_slots[i]


def _no_keys(size: int) -> NDArray[np.int64]:
    return np.full(size, _EMPTY, dtype=np.int64)


@dataclass
class RutGrid:
    """The soil's memory of every wheel that passed.

    spacing: distance of the nodes (m). The arrays are the kernel's: keys (H,) and slots (H,) of the hash, count (1,)
    tiles in use, nodes (capacity, 64, 4) with the columns SINKAGE, PLASTIC, YIELD, SHEAR. Raises ValueError unless
    spacing > 0.
    """

    spacing: float
    keys: NDArray[np.int64] = field(default_factory=lambda: _no_keys(256))
    slots: NDArray[np.int64] = field(default_factory=lambda: np.zeros(256, dtype=np.int64))
    count: NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    nodes: NDArray[np.float64] = field(default_factory=lambda: np.zeros((128, TILE_NODES, 4)))

    def __post_init__(self) -> None:
        if not self.spacing > 0:
            raise ValueError(f"grid: expected a spacing > 0 m, found {self.spacing}")

    @property
    def tiles(self) -> int:
        """Tiles in use."""
        return int(self.count[0])

    @property
    def memory(self) -> int:
        """Bytes that the tiles in use hold."""
        return self.tiles * TILE_NODES * 4 * 8

    def room(self, tiles: int) -> bool:
        """Whether so many tiles can be added without growing."""
        need = self.tiles + tiles
        return need <= len(self.nodes) and 2 * need <= len(self.keys)

    def reserve(self, tiles: int) -> None:
        """Make room for so many further tiles; arrays double, so the cost per tile stays constant."""
        while self.tiles + tiles > len(self.nodes):
            self.nodes = np.concatenate([self.nodes, np.zeros_like(self.nodes)])
        while 2 * (self.tiles + tiles) > len(self.keys):
            keys, slots = _no_keys(2 * len(self.keys)), np.zeros(2 * len(self.slots), dtype=np.int64)
            _rehash(self.keys, self.slots, keys, slots)
            self.keys, self.slots = keys, slots

    def copy(self) -> RutGrid:
        """An independent copy."""
        return RutGrid(self.spacing, self.keys.copy(), self.slots.copy(), self.count.copy(), self.nodes.copy())

    def node_table(self) -> NDArray[np.float64]:
        """(N, 7) touched nodes: x, y (m), layer, then the four columns of their memory."""
        used = np.flatnonzero(self.keys != -1)
        key = self.keys[used]
        row = ((key >> 29) & ((1 << 29) - 1)) - _OFFSET
        column = (key & ((1 << 29) - 1)) - _OFFSET
        inner = np.arange(TILE_NODES)
        x = (row[:, None] * TILE + inner[None, :] // TILE) * self.spacing
        y = (column[:, None] * TILE + inner[None, :] % TILE) * self.spacing
        layer = np.broadcast_to((key >> 58)[:, None], x.shape)
        memory = self.nodes[self.slots[used]]
        table = np.concatenate([np.stack([x, y, layer.astype(float)], axis=-1), memory], axis=-1).reshape(-1, 7)
        return table[table[:, 3 + YIELD] > 0]
