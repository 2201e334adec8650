"""The numbers of a vehicle that kinematics needs: axle distances, tracks, the wheels' radius and width, mass, inertia."""

from __future__ import annotations

from typing import Protocol


class Geometry(Protocol):
    """Anything with a vehicle's numbers (SI units); `softsoil.symbolic.vehicle.Vehicle` is one."""

    @property
    def mass(self) -> float:
        """Mass, kg."""

    @property
    def l_f(self) -> float:
        """Front axle ahead of the centre of gravity, m."""

    @property
    def l_r(self) -> float:
        """Rear axle behind the centre of gravity, m."""

    @property
    def yaw_inertia(self) -> float:
        """Yaw inertia, kg m^2."""

    @property
    def track(self) -> float:
        """Distance between the front wheels, m."""

    @property
    def rear_track(self) -> float:
        """Distance between the rear wheels, m."""

    @property
    def radius(self) -> float:
        """Rolling radius of the front wheels, m."""

    @property
    def rear_radius(self) -> float:
        """Rolling radius of the rear wheels, m."""

    @property
    def width(self) -> float:
        """Width of the front wheels, m."""

    @property
    def rear_width(self) -> float:
        """Width of the rear wheels, m."""


def radius_of(geometry: Geometry, channel: str) -> float:
    """Radius of the wheel whose speed a channel is, of a front one for any other channel (m)."""
    return geometry.rear_radius if channel.startswith("omega_r") else geometry.radius


def corners(geometry: Geometry) -> dict[str, tuple[float, float, bool]]:
    """Wheel channel -> (x, y) of the wheel from the centre of gravity (m) and whether it is steered."""
    axles = {"f": (geometry.l_f, geometry.track / 2, True), "r": (-geometry.l_r, geometry.rear_track / 2, False)}
    return {f"omega_{a}{side}": (x, y if side == "l" else -y, steered) for a, (x, y, steered) in axles.items() for side in "lr"}
