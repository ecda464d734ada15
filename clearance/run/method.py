"""The method of a run: its stepper, the functions that the loop calls, and its changes where a run
is held up.
"""

import logging
from importlib import import_module
from weakref import proxy

import numpy as np

from clearance.machine import store
from clearance.run.options import STAGED, choose_method, implicit, kernel_roles
from clearance.stepping import status
from clearance.stepping.state import CONTACTS, FUNCTIONS, KERNELS, PULL, RATE_X, STEPPER

LOG = logging.getLogger("clearance")
# trial steps between two looks at the pace, and those of a run at which it ends
PACE, ENDLESS = 200_000, 1e9
CHANGES = 8  # of the method where films stop it, at most


class Method:
    """The method of one run.

    names: of the steppers so far, in their order; reason: of the choice and of the changes.

    roles: of the kernels that the stepper needs; links: functions and room by address, for the
    loop. paced: the run goes to its end, and ends where it crawls.
    """

    def __init__(self, run):
        self.run = proxy(run)  # which holds it: no circle, so that its memory is free at once
        first, self.reason = choose_method(run.mechanism, run.solver.method, run.rtol)
        self.names, self.paced = [first], False
        self._pace = 0, 0.0  # trial steps and time since the last look

    @property
    def current(self) -> str:
        """Name of the stepper in use."""
        return self.names[-1]

    @property
    def text(self) -> str:
        """Names of all steppers so far."""
        return ", ".join(self.names)

    @property
    def fuses(self) -> bool:
        """True where the stages of the stepper in use are evaluated together."""
        if self.current not in STAGED:
            return False
        stepper = import_module(f"clearance.stepping.{self.current}")
        return self.run.mechanism.structure.fuses(stepper.MOMENTS)

    def use(self, name: str) -> None:
        """Use a stepper: its functions, the kernels it needs, its scratch."""
        run, mechanism = self.run, self.run.mechanism
        stepper = import_module(f"clearance.stepping.{name}")
        self.roles = kernel_roles(mechanism, name)
        if not run.outputs:
            self.roles.remove("observe")
        # the loop takes a function for every role; one that is not needed is never called, so any
        # will do
        functions = {r: mechanism.kernel(r if r in self.roles else "rhs") for r in KERNELS}
        if together := self.fuses:
            functions["moments"] = mechanism.kernel(f"{stepper.MOMENTS} moments")
        functions |= {part: getattr(stepper, part) for part in STEPPER}
        touching = import_module("clearance.stepping.contacts") if run.touchable else None
        functions |= {part: getattr(touching, part, stepper.step) for part in CONTACTS}
        if not run.outputs:
            functions["observe"] = run.loop.copy_state
        self.links = {part: store.address(f, FUNCTIONS[part]) for part, f in functions.items()}
        # times and states of stages that are evaluated together, and their rates
        numbers = (2, stepper.MOMENTS * (mechanism.y0.size + 1)) if together else (0, 0)
        self.links["together"] = np.zeros(numbers)
        run.resize(scratch=stepper.ROWS)
        run.state.order, run.state.degree = stepper.ORDER, stepper.DEGREE

    def judge(self, code: int, tried: int, passed: float) -> int:
        """The status with which the run goes on after a call of the loop.

        code: status of the call; tried, passed: its trial steps and time [s].
        """
        if code == status.STIFF:
            self._become_implicit()
            return status.RUNNING
        self._use_fused_stages()
        if code == status.RUNNING and self._crawls(tried, passed):
            code = status.CRAWLING
        stuck = code in (status.STEP_TOO_SMALL, status.CRAWLING)
        helped = stuck and (self._resolves_films() or self._can_change())
        return status.RUNNING if helped else code

    def _go_on_with(self, name: str) -> None:
        """Use another stepper from here on."""
        self.names.append(name)
        self.use(name)

    def _become_implicit(self) -> None:
        """The explicit method of an automatic choice is held up by stability: go on with an
        implicit one.
        """
        name = implicit(self.run.rtol, stages_only=True)
        state = self.run.state
        LOG.info("stiff: going on with %s", name)
        self.reason = f"explicit at first; stiff, so implicit from t = {state.time:.6g} s on"
        state.may_switch = state.stiff_steps = 0
        state.stiffness = 0.0
        self._go_on_with(name)

    def _use_fused_stages(self) -> None:
        """Take the kernel that only a structure of many steps pays for; no bit changes."""
        if not self.links["together"].size and self.fuses:
            self.use(self.current)

    def _crawls(self, tried: int, passed: float) -> bool:
        """True where the run would need too many steps at its pace, unless it has a step limit."""
        self._pace = self._pace[0] + tried, self._pace[1] + passed
        if self._pace[0] < PACE or self.run.solver.max_steps or not self.paced:
            return False
        (tried, passed), self._pace = self._pace, (0, 0.0)
        return passed * ENDLESS < tried * self.run.span.until

    def _resolves_films(self) -> bool:
        """True where rates in mixed joints are judged by what their films resolve from here on.

        That takes two to seven times the steps, so it is for runs that are stuck.
        """
        contacts = self.run.state.contacts
        loose = (contacts[:, RATE_X] > 0.0) & (contacts[:, PULL] == 0.0)
        if not loose.any():
            return False
        contacts[loose, PULL] = self.run.mechanism.acceleration
        self._begin_phase()
        return True

    def _can_change(self) -> bool:
        """True where a film stops the method of an automatic choice; another one goes on from here.

        Radau's iterations may fail where a film's force turns round, which a step of Rodas5P
        survives, and the other way round.
        """
        run = self.run
        films = any(j.film is not None for j in run.mechanism.scene.clearance_joints)
        if run.solver.method != "auto" or not films or len(self.names) > CHANGES:
            return False
        name = "radau5" if self.current == "rodas5p" else "rodas5p"
        LOG.info("stuck: going on with %s", name)
        self.reason += f"; stuck at t = {run.state.time:.6g} s, so {name} from there on"
        self._go_on_with(name)
        self._begin_phase()
        return True

    def _begin_phase(self) -> None:
        """A phase begins, with a first step of its own."""
        self.run.interrupt_steps()
        state = self.run.state
        state.started, state.free_step, state.contact_step = 2, 0.0, 0.0
