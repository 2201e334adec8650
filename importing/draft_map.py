"""A draft of the map from what a recording holds: standard messages by type, the rest by the names of their fields."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from softsoil.importing.earth_velocity import EARTH
from softsoil.importing.frames import VEHICLE, Place, places
from softsoil.importing.hanging import hangs
from softsoil.importing.import_map import CHANNELS, UNITS_BESIDE
from softsoil.importing.message_columns import message_field
from softsoil.importing.messages import SPEED
from softsoil.importing.sources import Holding, Spread
from softsoil.importing.written_units import measures, without_unit, written_unit
from softsoil.recording.drive import CHANNEL_UNITS, WHEEL_CHANNELS

STANDARD: dict[str, tuple[tuple[str, str], ...]] = {
    "nav_msgs/msg/Odometry": (
        ("x", "pose.pose.position.x"), ("y", "pose.pose.position.y"), ("psi", "pose.pose.orientation.heading"),
        ("u", "twist.twist.linear.x"), ("v", "twist.twist.linear.y"), ("omega_z", "twist.twist.angular.z"),
    ),
    "sensor_msgs/msg/Imu": (
        ("omega_z", "angular_velocity.z"), ("a_x_imu", "linear_acceleration.x"), ("a_y_imu", "linear_acceleration.y"),
        ("psi", "orientation.heading"),
    ),
    "sensor_msgs/msg/NavSatFix": (("x", "east"), ("y", "north")),
    "geometry_msgs/msg/TwistStamped": (("u", "twist.linear.x"), ("v", "twist.linear.y"), ("omega_z", "twist.angular.z")),
    "geometry_msgs/msg/Twist": (("u", "linear.x"), ("v", "linear.y"), ("omega_z", "angular.z")),
    "geometry_msgs/msg/TwistWithCovarianceStamped": (
        ("u", "twist.twist.linear.x"), ("v", "twist.twist.linear.y"), ("omega_z", "twist.twist.angular.z"),
    ),
    "geometry_msgs/msg/PoseStamped": (("x", "pose.position.x"), ("y", "pose.position.y"), ("psi", "pose.orientation.heading")),
    "geometry_msgs/msg/Pose": (("x", "position.x"), ("y", "position.y"), ("psi", "orientation.heading")),
    "geometry_msgs/msg/PoseWithCovarianceStamped": (
        ("x", "pose.pose.position.x"), ("y", "pose.pose.position.y"), ("psi", "pose.pose.orientation.heading"),
    ),
    "ackermann_msgs/msg/AckermannDriveStamped": (("steer", "drive.steering_angle"), ("u", "drive.speed")),
    "ackermann_msgs/msg/AckermannDrive": (("steer", "steering_angle"), ("u", "speed")),
    "autoware_vehicle_msgs/msg/SteeringReport": (("steer", "steering_tire_angle"),),
    "autoware_vehicle_msgs/msg/VelocityReport": (
        ("u", "longitudinal_velocity"), ("v", "lateral_velocity"), ("omega_z", "heading_rate"),
    ),
    "autoware_auto_vehicle_msgs/msg/SteeringReport": (("steer", "steering_tire_angle"),),
    "autoware_auto_vehicle_msgs/msg/VelocityReport": (
        ("u", "longitudinal_velocity"), ("v", "lateral_velocity"), ("omega_z", "heading_rate"),
    ),
}  # fmt: skip
"""Message type -> channel, field. Best first where two sources offer one channel: an odometry's pose before a GPS fix; the IMU's
yaw rate before all others."""
PREFERRED = {"omega_z": ("Imu",), "x": ("Odometry", "Pose"), "y": ("Odometry", "Pose"), "u": ("Odometry", "Velocity", "Twist"),
             "psi": ("Odometry", "Pose"), "steer": ("SteeringReport", "JointState")}  # fmt: skip
_SPINS, _TURNS = "wheel|omega|ws|spin|rpm", "wheel|omega|ws|speed|rpm"
_PLACE = r"\A(?!.*(?<![a-z])(gyro?s?|acc\w*|mag|omega|rate|vel|velocity|speed|force|torque|angular|roll|pitch|twist)(?![a-z])).*"
_CORNERS = {"omega_fl": "fl|front_?left|lf|left_?front", "omega_fr": "fr|front_?right|rf|right_?front",
            "omega_rl": "rl|rear_?left|lr|left_?rear", "omega_rr": "rr|rear_?right|right_?rear"}  # fmt: skip
NAMES: tuple[tuple[str, str], ...] = (
    *((channel, rf"({_SPINS}).*({corner})|({corner}).*({_TURNS})") for channel, corner in _CORNERS.items()),
    ("steer", r"steer(?!.*(rate|torque|vel))|(?<![a-z])(swa\Z|delta(?!_?[tv]))|(road|hand)_?wheel(_?angle)?\Z"
     r"|(?<![a-z])column(_?angle)?\Z|lenk(rad)?winkel"),
    ("omega_z", r"yaw_?rate|omega_?z|gyro_?z|angular_velocity\.z|heading_rate|(?<![a-z])wz(?![a-z])|gierrate"),
    ("a_x_imu", r"(accel\w*|acc|a)_?\.?(x|lon(g\w*)?|forwards?|fwd|ahead)(_?(imu|cg))?\Z|linear_acceleration\.x"),
    ("a_y_imu", r"(accel\w*|acc|a)_?\.?(y|lat\w*|left)(_?(imu|cg))?\Z|linear_acceleration\.y"),
    ("velocity_east", r"(?<![a-z])(v(el\w*?)?_?\.?e(ast)?|(vel\w*|speed)_?east|e(ast)?(ward)?_(v(el\w*)?|speed))\Z"),
    ("velocity_north", r"(?<![a-z])(v(el\w*?)?_?\.?n(orth)?|(vel\w*|speed)_?north|n(orth)?(ward)?_(v(el\w*)?|speed))\Z"),
    ("psi", r"(?<!wheel_)(yaw|heading|hdg|psi|bearing|azimuth|gierwinkel)\Z"),
    ("v", r"(?<![a-z])(?!velocity\Z)(v(el\w*?)?_?(y|lat\w*|left)|lateral_?(vel\w*|speed)|speed_?lat\w*|v)\Z"),
    (
        "u",
        r"(?<![a-z])(v(el\w*?)?_?(x|long\w*|forwards?|fwd|ahead)|longitudinal_?(vel\w*|speed)|speed(?!_?(left|right|lat|side))(_?[a-z]*)?|velocity|"
        r"geschwindigkeit|u)\Z",
    ),
    ("throttle", r"throttle|gas"), ("brake", r"brake"),
    ("x", rf"{_PLACE}(?<![a-z])(x|pos\w*_?\.?x|east(ing)?)\Z"), ("y", rf"{_PLACE}(?<![a-z])(y|pos\w*_?\.?y|north(ing)?)\Z"),
)  # fmt: skip
"""Channel, pattern of a field's or column's name (its last part first, lower case, without a unit at its end)."""
GENERAL = ("data", "value", "velocity", "speed", "rpm")
"""Last parts of a path that say what is measured, and not of what."""
BEARING, EASTING = re.compile(r"bearing|azimuth", re.I), re.compile(r"easting", re.I)
"""Names of a heading that is clockwise from north, and of a position in a grid of the earth."""
STEEPEST, FASTEST_TURN = 1.3, 6.0
"""rad, rad/s: largest road-wheel angle and yaw rate of a wheeled vehicle; beyond it degrees are guessed."""
STEERING = re.compile(r"steer", re.I)
COMMANDED = re.compile(r"(?<![a-z])(cmd|command|commanded|target|set_?point|desired|demand|request|requested)(?![a-z])", re.I)
"""Names of what was asked for: a measured channel comes before it."""
SIDEWAYS = r"(?!.*(?:\A|[./_ ])(?:a|acc\w*|v|vel\w*|speed)[./_ ]l(?:at|on|ng))"
"""What no latitude and longitude begin with: lateral and longitudinal accelerations and speeds."""
RECEIVER = re.compile(r"gps|gnss|fix|ublox|novatel|septentrio", re.I)
"""Topics of satellite receivers, whose velocities are to the east and north."""
UNITS = {**CHANNEL_UNITS, **UNITS_BESIDE}
BOTH = "; both, turned by psi, are u and v"
HEAD = (
    "# Draft map. Check each line: source, unit, sign (ISO 8855: x ahead, y left, heading and yaw rate to the left).",
    "# Keys: source, unit, factor, sign, offset, ratio (steering wheel over road wheel), table, compass, rate, late (s).",
)
PLACES = (
    "# Place and turn of a sensor, from the centre of gravity (m ahead, m left; rad). Without it all is taken at the centre",
    "# of gravity but positions of tables, at the front axle.",
    '# frame = "z-down" for x ahead, y right; point = "front_axle" where a device does the arm.',
)

NEEDED = "needed"
DERIVED = {"x": "else dead reckoned, on no map", "y": "else dead reckoned, on no map", "v": "else from the positions, or unknown"}
"""Channels that logs often have under a name of their own, and what is done without them."""

@dataclass(frozen=True)
class Offer:
    """A field that may be a channel: channel, source, path, unit guessed (empty for SI), why, score (larger is better).

    beside: other fields of the source that the channel is the mean of; rate: whether it is their rate of change; compass: whether
    it is clockwise from north.
    """

    channel: str
    source: str
    path: str
    unit: str
    why: str
    score: float
    beside: tuple[str, ...] = ()
    rate: bool = False
    compass: bool = False


def offers(holdings: Sequence[Holding]) -> list[Offer]:
    """Every field of the sources that looks like a channel, best first."""
    found: list[Offer] = []
    for holding in holdings:
        found += _of_joints(holding) if holding.kind.endswith("JointState") else _of_fields(holding)
    return sorted(found, key=lambda offer: -offer.score)


def _type(kind: str) -> str:
    parts = kind.split("/")
    return f"{parts[0]}/msg/{parts[-1]}" if len(parts) > 1 else kind


def _of_fields(holding: Holding) -> list[Offer]:
    standard = STANDARD.get(_type(holding.kind))
    found = []
    if standard is not None:
        if "Twist" in holding.kind and RECEIVER.search(holding.name):
            velocity = next(path for channel, path in standard if channel == "u").rsplit(".", 1)[0]
            standard = tuple(zip(("u", *EARTH), (f"{velocity}.{part}" for part in (SPEED, "x", "y")), strict=True))
        for channel, path in standard:
            spread = holding.fields.get(path)
            if path not in ("east", "north") and (spread is None or not spread.changes):
                continue  # a constant says nothing: an empty orientation, a lateral velocity that nobody measures
            found.append(
                Offer(
                    channel, holding.name, path, _unit(channel, spread), _type(holding.kind), _score(channel, holding)
                )
            )
        return found
    for path, spread in holding.fields.items():
        named = channel_named(path)
        if (
            named is None
            and STEERING.search(f"{holding.name} {holding.kind}")
            and re.search(r"angle|position", path, re.I)
        ):
            named = "steer"
        if named in ("u", "v") and message_field(path) == named and RECEIVER.search(f"{holding.name} {path}"):
            continue  # a receiver's velocities are to the east and north
        if named and spread.changes and _can_be(named, written_unit(path, spread)):
            unit = _unit(named, spread, path)
            bearing = named == "psi" and _is_bearing(path, spread, unit, holding)
            likely = (0.5 if COMMANDED.search(path) else 1.0) - 1e-3 * len(path)
            found.append(Offer(named, holding.name, path, unit, "its name", likely, compass=bearing))
    if geodetic(list(holding.fields)) is not None:
        found += [
            Offer(c, holding.name, p, "", "latitude and longitude", 0.5) for c, p in (("x", "east"), ("y", "north"))
        ]
    return found


def _can_be(channel: str, unit: str) -> bool:
    """Whether a field in `unit` can be the channel: a wheel's speed may be that of its rim."""
    si = UNITS[channel]
    others = ("m/s",) if channel in WHEEL_CHANNELS else ("rad",) if si == "rad/s" else ()  # yaw_rate_deg is in deg/s
    return any(measures(unit, one) for one in (si, *others))


def _of_joints(holding: Holding) -> list[Offer]:
    """Wheels by their velocity, or by their position where that is all; the steering angle as the mean of all that steer."""
    found: list[Offer] = []
    steered: list[str] = []
    for path, spread in holding.fields.items():
        kind, _, name = path.partition("[")
        name = name.rstrip("]")
        if kind == "position" and re.search(r"steer", name, re.I):
            steered.append(path)
            continue
        channel = channel_named(name)
        if channel not in WHEEL_CHANNELS or not spread.changes:
            continue
        if kind == "velocity":
            found.append(Offer(channel, holding.name, path, "", "joint's name", 2.0))
        elif kind == "position":
            found.append(Offer(channel, holding.name, path, "", "joint's name", 1.0, rate=True))
    if steered:
        # Of a wheel's own joints, the mean of left and right; an axle that is steered by one joint has that.
        own = [path for path in steered if re.search(r"left|right|_[lr](_|\b|\])|[fr][lr]\b", path, re.I)]
        front = [path for path in own if re.search(r"front|(\b|_)f[lr]|(\b|_)[lr]f", path, re.I)]
        first, *beside = next((pair for pair in (own, front) if len(pair) == 2), steered[:1])
        unit = _unit("steer", holding.fields[first])
        found.append(Offer("steer", holding.name, first, unit, "joint's name", 2.0, tuple(beside)))
    return found


def _score(channel: str, holding: Holding) -> float:
    words = PREFERRED.get(channel, ())
    rank = next((len(words) - i for i, word in enumerate(words) if word in holding.kind), 0)
    return 2.0 + rank + 1e-4 * min(holding.rate_hz, 1000.0) if holding.rate_hz == holding.rate_hz else 2.0 + rank


def channel_named(path: str) -> str | None:
    """The channel that a field's or column's name stands for, None for no likeness."""
    full = path.strip().lower().replace(" ", "_")
    if full in CHANNELS:
        return full
    if (field := message_field(full)) is not None:
        return field or None
    parts = re.split(r"[./]", full)
    if len(parts) > 1 and (parts[-1] in GENERAL or (parts[-1] in ("east", "north") and re.match("vel|speed", parts[-2]))):
        parts[-1] = parts[-2] if parts[-1] in ("data", "value") else f"{parts[-2]}_{parts[-1]}"
    for text in filter(None, (without_unit(parts[-1]), parts[-1], full)):
        for channel, pattern in NAMES:
            if re.search(pattern, text):
                return channel
    return None


def geodetic(names: Sequence[str]) -> tuple[str, str, str] | None:
    """Names of latitude, longitude and altitude (may be empty) among `names`; None where there is no pair."""
    found = []
    for pattern in (
        rf"{SIDEWAYS}(?:.*[./_ ])?lat(itude)?(_deg)?\Z",
        rf"{SIDEWAYS}(?:.*[./_ ])?(lon|lng|longitude)(_deg)?\Z",
        r"(?:.*[./_ ])?(alt|altitude|height)(_m)?\Z",
    ):
        found.append(next((name for name in names if re.match(pattern, name, re.I)), ""))
    return (found[0], found[1], found[2]) if found[0] and found[1] else None


def _unit(channel: str, spread: Spread | None, path: str = "") -> str:
    """Unit by what the file says, by the end of the name, or by the size of the values; empty for SI."""
    if spread is None:
        return ""
    said = written_unit(path, spread)
    if UNITS[channel] == "rad/s" and said in ("deg", "rad"):
        said += "/s"
    if said:
        return "" if said == UNITS[channel] else said
    largest = max(abs(spread.least), abs(spread.largest))
    if (channel == "steer" and largest > STEEPEST) or (channel == "psi" and largest > 8.0):
        return "deg"
    return "deg/s" if channel == "omega_z" and largest > FASTEST_TURN else ""


def draft(holdings: Sequence[Holding]) -> str:
    """The draft map as TOML text: the best offer of each channel, others as comments, what is missing said."""
    best: dict[str, Offer] = {}
    others: dict[str, list[Offer]] = {}
    for offer in offers(holdings):
        if offer.channel in best:
            others.setdefault(offer.channel, []).append(offer)
        else:
            best[offer.channel] = offer
    lines = [*HEAD, "", "[channels]"]
    turned = _turned_velocities(best)
    for channel in (*CHANNELS, *EARTH):
        if channel not in best:
            continue
        offer, more = best[channel], BOTH if channel in EARTH else ""
        off = "# " if channel in (EARTH.values() if turned else EARTH) else ""
        lines.append(f"{off}{channel} = {_entry(offer)}  # {UNITS[channel] or '-'}, by {offer.why}{more}")
        lines += [f"# {channel} = {_entry(other)}" for other in others.get(channel, [])[:3]]
    for channel, without in (("u", NEEDED), ("omega_z", NEEDED), ("steer", NEEDED), *DERIVED.items()):
        if channel not in best and not (turned and channel in EARTH.values()):
            lines.append(f'# {channel} = "source:field"  # {without}: nothing like it was recognised')
    asked = next((o for o in (best.get("steer"), *others.get("steer", ())) if o is not None and COMMANDED.search(o.path)), None)
    if asked is not None:
        lines.append(f"# steer_command = {_entry(asked)}  # beside steer it fits [steering], by which it alone becomes steer")
    if any(o.channel == "steer" and o.unit == "deg" for o in best.values()):
        lines.append(
            "# steer: if this is the angle of the steering wheel, add ratio = (steering wheel over road wheel)."
        )
    lines += ["", *PLACES]
    known = places([one for h in holdings for one in h.transforms])
    for h in holdings:
        lines += _mount(h, known.get(h.frame))
    lines += ["", "# [clock]", "# rate_hz = 50  # default: that of the yaw rate, 100 at most"]
    lines += ["# start = 0.0  # s; with end, the part of the recording that is wanted"]
    return "\n".join(lines) + "\n"


def _turned_velocities(best: Mapping[str, Offer]) -> bool:
    """Whether u and v are best made of velocities to the east and north; the zero of an inertial sensor's heading is anywhere."""
    pair, absolute = [best[name] for name in EARTH if name in best], "psi" in best and "Imu" not in best["psi"].why
    own = [best[name].path.endswith(f".{SPEED}") for name in EARTH.values() if name in best]
    return len(pair) == len(EARTH) and pair[0].source == pair[1].source and (not own or (own == [True] and absolute))


def _mount(holding: Holding, place: Place | None) -> list[str]:
    """The lines on a source's place: as the recording's transforms have it, or blank; none for what has no place."""
    hanging, odometry = hangs(holding), _is_odometry(holding)
    mark = "" if hanging or odometry else "# "
    if mark and place is None and not _has_place(holding):
        return []
    at = place or Place("", 0.0, 0.0, 0.0, False)
    head = f"{mark}[mount.{json.dumps(holding.name)}]"
    if place is not None:
        head += f"  # {holding.frame} from {place.base}, by the transforms: add {place.base}'s own x, -l_r at the rear axle"
    elif holding.frame in VEHICLE:
        head += f"  # of {holding.frame}: x = -l_r where that is the rear axle"
    about = "as an odometry's; of the rear axle (base_link): x = -l_r in its place"
    point = [f'point = "centre_of_gravity"  # {about}'] if odometry else []
    lines = [head, *point, *(f"# {name} = {value:.3f}" for name, value in (("x", at.x), ("y", at.y), ("yaw", at.yaw)))]
    if hanging or at.upside_down:
        why = "its accelerometer reads gravity as that of a sensor with z down does" if hanging else "its frame's z points down"
        lines.append(f'{mark}frame = "z-down"  # {why}')
    return lines


def _is_odometry(holding: Holding) -> bool:
    """Whether a table's positions are those of messages: these are not taken at the front axle."""
    return holding.kind == "table" and any(message_field(path) in ("x", "y") for path in holding.fields)


def _has_place(holding: Holding) -> bool:
    return any(word in holding.kind for word in ("Odometry", "NavSatFix", "Imu", "Pose")) or bool(
        geodetic(list(holding.fields))
    )


def _is_bearing(path: str, spread: Spread, unit: str, holding: Holding) -> bool:
    """Whether a heading is clockwise from north: by its name, or as receivers give it beside their fixes, 0 to 360 deg."""
    beside = geodetic(list(holding.fields)) is not None or any(EASTING.search(name) for name in holding.fields)
    return bool(BEARING.search(path)) or (unit == "deg" and spread.least >= 0.0 and beside)


def _entry(offer: Offer) -> str:
    sources = [json.dumps(f"{offer.source}:{path}", ensure_ascii=False) for path in (offer.path, *offer.beside)]
    source = f"[{', '.join(sources)}]" if offer.beside else sources[0]
    more = (f', unit = "{offer.unit}"' if offer.unit else "") + (", rate = true" if offer.rate else "")
    more += ", compass = true" if offer.compass else ""
    return f"{{source = {source}{more}}}" if more else source
