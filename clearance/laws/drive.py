"""Finite drives: torque over speed of motors, speed control, and run-ups.

Efforts are torques [N m] on a rotating coordinate and forces [N] along a slide. Positions and rates
are then in rad and rad/s, or m and m/s.
"""

from clearance.laws.law import drive_state, effort, signal
from clearance.values.checks import non_negative, nonzero, positive


def ramped(time, run_up):
    """Share t / t_r of a run-up that is over, 1 after it [-]."""
    return time / run_up if time < run_up else 1.0


@effort(stall=positive, no_load=nonzero)
def motor_line(time, position, rate, stall, no_load):
    """T = T_s sign(w_0) (1 - w / w_0) [N m]: the straight line of a motor.

    stall T_s [N m] at rest; no_load w_0 [rad/s], whose sign is the way it turns. Valid for a DC
    motor without inductance, or an induction motor between no load and its rated torque. It brakes
    beyond w_0 and has no limit there. A stiff line, T_s -> inf, is the prescribed speed w_0.
    Raises ValueError for a stall that is not positive and a no_load of 0.
    Source: Leonhard, Control of Electrical Drives, 3rd ed., Springer 2001, ch. 5.
    """
    return stall * (no_load - rate) / abs(no_load)


@effort(breakdown=positive, slip=positive, synchronous=nonzero)
def kloss(time, position, rate, breakdown, slip, synchronous):
    """T = 2 T_b s s_b / (s^2 + s_b^2) sign(w_s), s = 1 - w / w_s [N m]: an induction motor's curve.

    breakdown T_b [N m], the largest torque; slip s_b at which it stands [-]; synchronous speed w_s
    [rad/s], whose sign is the way it turns. Valid for slow changes, without the stator's
    resistance. Beyond w_s it brakes with the same curve. Near w_s it is a line with the stall
    torque 2 T_b / s_b.
    Raises ValueError for numbers that are not positive and a synchronous speed of 0.
    Source: Kloss, Archiv fuer Elektrotechnik 5 (1917) 59.
    """
    s = 1.0 - rate / synchronous
    torque = 2.0 * breakdown * slip * s / (s * s + slip * slip)
    return torque if synchronous > 0.0 else -torque


@drive_state(
    proportional=positive,
    integral=non_negative,
    limit=non_negative,
    run_up=non_negative,
    kinks=lambda values: [values["run_up"]],
    own_state=("integral", "rad", "integral of the speed's error, as the limit lets it"),
)
def pi_speed(state, time, position, rate, proportional, integral, speed, limit=0.0, run_up=0.0):
    """T = K_p (w_r - w) + K_i z [N m], |T| <= limit: speed control with anti-windup.

    proportional K_p [N m s/rad]; integral K_i [N m/rad]; limit of the torque [N m] (0: none). Speed
    w_0 [rad/s]; w_r reaches it in a straight ramp of run_up [s] (0: at once). The state z [rad] is
    the integral of the error, z' = w_r - w + (T - T*) / K_p, where T* is the torque without
    limit: back-calculation, which lets z follow a limited torque within K_p / K_i.
    Valid for a control without delay. Without integral it is `motor_line` with stall K_p w_0 and no
    load w_0.
    Raises ValueError for a proportional gain that is not positive and other negative numbers.
    Source: Astroem and Haegglund, Advanced PID Control, ISA 2006, sec. 3.5.
    """
    error = ramped(time, run_up) * speed - rate
    wanted = proportional * error + integral * state
    if limit > 0.0:
        effort = min(max(wanted, -limit), limit)
        return error + (effort - wanted) / proportional, effort
    return error, wanted


def motor_voltage(state, time, position, rate, voltage, resistance, inductance, constant, run_up):
    """Voltage at the motor [V]."""
    return voltage * ramped(time, run_up)


def electric_power(state, time, position, rate, voltage, resistance, inductance, constant, run_up):
    """Electric power that the motor takes, V i [W]."""
    return voltage * ramped(time, run_up) * state


def motor_efficiency(
    state, time, position, rate, voltage, resistance, inductance, constant, run_up
):
    """T w / (T w + R i^2) where the motor drives [-]; 0 where it brakes."""
    power = constant * state * rate
    return power / (power + resistance * state * state) if power > 0.0 else 0.0


@drive_state(
    voltage=nonzero,
    resistance=positive,
    inductance=positive,
    constant=positive,
    run_up=non_negative,
    kinks=pi_speed.kinks,
    own_state=("current", "A", "current"),
    size=lambda values: abs(values["voltage"]) / values["resistance"],
    shown={
        "voltage": ("V", "voltage at the motor", motor_voltage),
        "electric_power": ("W", "electric power that the motor takes", electric_power),
        "efficiency": (
            "1",
            "power at the shaft over it and the winding's loss, 0 where it brakes",
            motor_efficiency,
        ),
    },
)
def dc_motor(state, time, position, rate, voltage, resistance, inductance, constant, run_up=0.0):
    """T = k i, L i' = V - R i - k w [N m]: a motor of direct current with permanent magnets.

    voltage V [V]; resistance R [Ohm]; inductance L [H]; constant k [N m/A = V s/rad]. The voltage
    rises in a straight ramp of run_up [s] (0: at once). The state is the current i [A], at first 0.
    Its electric time constant is L / R; for L -> 0 it is `motor_line` with stall k V / R and no
    load V / k. Valid without iron losses and brushes' drop. Raises ValueError for numbers that
    are not positive and a voltage of 0.
    Source: Leonhard, Control of Electrical Drives, 3rd ed., Springer 2001, ch. 5.
    """
    applied = ramped(time, run_up) * voltage
    return (applied - resistance * state - constant * rate) / inductance, constant * state


@signal(duration=positive, kinks=lambda values: [values["duration"]])
def ramp(time, speed, duration, start=0.0):
    """q = q_0 + w t^2 / (2 t_r) up to t_r, then q_0 + w (t - t_r / 2) [rad or m]: a run-up.

    speed w [rad/s or m/s], reached in the duration t_r [s] at constant acceleration, then constant;
    start q_0 [rad or m]. Valid from 0 s on. The acceleration jumps at t_r and at 0, the rate does
    not. Raises ValueError for a duration that is not positive.
    Source: uniform acceleration.
    """
    if time < duration:
        return start + 0.5 * speed * time * time / duration
    return start + speed * (time - 0.5 * duration)
