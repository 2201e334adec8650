"""The numbers of a vehicle that kinematics needs: axle distances, tracks, the wheels' radius and width, mass, inertia."""

from __future__ import annotations

from typing import Protocol


class Geometry(Protocol):
    """Anything with a vehicle's numbers (SI units); `softsoil.symbolic.vehicle.Vehicle` is one."""

    @property
    def mass(self) -> float:
        """Mass, kg."""
        ...

    @property
    def l_f(self) -> float:
        """Front axle ahead of the centre of gravity, m."""
        ...

    @property
    def l_r(self) -> float:
        """Rear axle behind the centre of gravity, m."""
        ...

    @property
    def yaw_inertia(self) -> float:
        """Yaw inertia, kg m^2."""
        ...

    @property
    def track(self) -> float:
        """Distance between the front wheels, m."""
        ...

    @property
    def rear_track(self) -> float:
        """Distance between the rear wheels, m."""
        ...

    @property
    def radius(self) -> float:
        """Rolling radius of the wheels, m."""
        ...

    @property
    def width(self) -> float:
        """Width of the wheels, m."""
        ...


def corners(geometry: Geometry) -> dict[str, tuple[float, float, bool]]:
    """Wheel channel -> (x, y) of the wheel from the centre of gravity (m) and whether it is steered."""
    front, rear = geometry.track / 2, geometry.rear_track / 2
    return {
        "omega_fl": (geometry.l_f, front, True),
        "omega_fr": (geometry.l_f, -front, True),
        "omega_rl": (-geometry.l_r, rear, False),
        "omega_rr": (-geometry.l_r, -rear, False),
    }
