"""Throttle powertrain without clutch, 4x4 driveline and brakes: from pedal and wheel speeds to wheel accelerations."""

from __future__ import annotations

from softsoil.plant.kernel import inner, kernel


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
def clutch(wanted, limit, engaged):
    """Torque of a lock's clutch: what makes both sides turn alike at the step's end, within its limit; 0 if open."""
    if engaged == 0.0:
        return 0.0
    return min(max(wanted, -limit), limit)


@inner
def spin_rates(machine, locked, drive, torque, spin, dt, rates):
    """Write the wheels' angular accelerations (rad/s^2).

    drive: torque at axle speed (N m), of which the centre gives the share front_drive to the front axle; torque (4,): of soil,
    brakes and bearings on each wheel about its axle; locked (3,): whether the clutches of centre, front and rear differential
    are engaged; spin (4,) rad/s. Axle differentials are symmetric; the centre's own inertia turns at the mean of both axles.
    """
    inertia, boxes, limit = machine.spin_inertia, machine.box_inertia, machine.lock_limit
    couple = 0.25 * boxes[0]
    own_front, own_rear = 2.0 * inertia + boxes[1] + couple, 2.0 * inertia + boxes[2] + couple
    to_front = machine.front_drive * drive
    front, rear = torque[0] + torque[1] + to_front, torque[2] + torque[3] + drive - to_front
    apart = 0.5 * (spin[0] + spin[1] - spin[2] - spin[3]) / dt
    det = own_front * own_rear - couple * couple
    # (front - t)(own_rear + couple) - (rear + t)(own_front + couple) = -apart det, solved for the clutch's torque t.
    gain_front, gain_rear = own_rear + couple, own_front + couple
    wanted = (front * gain_front - rear * gain_rear + apart * det) / (gain_front + gain_rear)
    across = clutch(wanted, limit[0], locked[0])
    front -= across
    rear += across
    mean = ((front * own_rear - rear * couple) / det, (rear * own_front - front * couple) / det)
    for axle in range(2):
        left, right = 2 * axle, 2 * axle + 1
        wanted = 0.5 * (torque[left] - torque[right] + inertia * (spin[left] - spin[right]) / dt)
        across = clutch(wanted, limit[1 + axle], locked[1 + axle])
        half = 0.5 * (torque[left] - torque[right] - 2.0 * across) / inertia
        rates[left], rates[right] = mean[axle] + half, mean[axle] - half
