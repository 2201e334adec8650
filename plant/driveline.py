"""Throttle powertrain without clutch, 4x4 driveline and brakes: from pedal and wheel speeds to wheel accelerations."""

from __future__ import annotations

from plant.kernel import inner, kernel


@kernel
def curve(table, x):
    """Linear interpolation in a table (N, 2) of growing x, held beyond its ends (np.interp takes long to compile)."""
    low, high = 0, table.shape[0] - 1
    if x <= table[low, 0]:
        return table[low, 1]
    if x >= table[high, 0]:
        return table[high, 1]
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= x:
            low = middle
        else:
            high = middle
    share = (x - table[low, 0]) / (table[high, 0] - table[low, 0])
    return table[low, 1] + share * (table[high, 1] - table[low, 1])


@kernel
def shift_gear(machine, gear, shaft_speed):
    """The gear (from 0) after the automatic's shift points, given the propeller shaft's speed (rad/s)."""
    motor = shaft_speed / machine.gears[gear]
    if motor > machine.shift[1] and gear < machine.gears.shape[0] - 1:
        return gear + 1
    if motor < machine.shift[0] and gear > 0:
        return gear - 1
    return gear


@inner
def axle_drive_torque(machine, gear, throttle, shaft_speed):
    """Torque of the engine at axle speed (N m): ((1 - throttle) T_zero + throttle T_full) final_drive / ratio."""
    motor = shaft_speed / machine.gears[gear]
    torque = (1.0 - throttle) * curve(machine.zero_throttle, motor) + throttle * curve(machine.full_throttle, motor)
    return torque / machine.gears[gear] * machine.final_drive


@inner
def spin_rates(machine, locked, drive, torque, spin, rates):
    """Write the wheels' angular accelerations (rad/s^2).

    drive: torque at axle speed (N m), split evenly where the centre differential is open; torque (4,): of soil, brakes
    and bearings on each wheel about its axle; locked (3,): centre, front, rear; spin (4,). An open axle differential
    lets its wheels differ about their mean; a locked centre keeps the two means equal; what was unequal before locking
    is averaged.
    """
    inertia = machine.spin_inertia
    centre, boxes = machine.box_inertia[0], machine.box_inertia
    front, rear = torque[0] + torque[1], torque[2] + torque[3]
    if locked[0] > 0.0:
        mean = (drive + front + rear) / (4.0 * inertia + centre + boxes[1] + boxes[2])
        mean_front = mean_rear = mean
    else:
        # The centre's own inertia turns at the mean of both axles: a quarter on each, coupled through their mean.
        own_front, own_rear = 2.0 * inertia + boxes[1] + 0.25 * centre, 2.0 * inertia + boxes[2] + 0.25 * centre
        couple = 0.25 * centre
        a, b = front + 0.5 * drive, rear + 0.5 * drive
        det = own_front * own_rear - couple * couple
        mean_front = (a * own_rear - b * couple) / det
        mean_rear = (b * own_front - a * couple) / det
    half_front = 0.0 if locked[1] > 0.0 else 0.5 * (torque[1] - torque[0]) / inertia
    half_rear = 0.0 if locked[2] > 0.0 else 0.5 * (torque[3] - torque[2]) / inertia
    rates[0], rates[1] = mean_front - half_front, mean_front + half_front
    rates[2], rates[3] = mean_rear - half_rear, mean_rear + half_rear


@kernel
def enforce_locks(locked, spin):
    """Make wheel speeds agree with the locks (after a change of either)."""
    if locked[0] > 0.0:
        shift = 0.25 * (spin[2] + spin[3] - spin[0] - spin[1])
        spin[0] += shift
        spin[1] += shift
        spin[2] -= shift
        spin[3] -= shift
    for axle in range(2):
        if locked[1 + axle] > 0.0:
            mean = 0.5 * (spin[2 * axle] + spin[2 * axle + 1])
            spin[2 * axle] = mean
            spin[2 * axle + 1] = mean
