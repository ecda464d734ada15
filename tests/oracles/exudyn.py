"""The same scene in Exudyn, a complete multibody code: redundant coordinates, generalized-alpha,
the joint's own film law.

Bodies, hinges, guides and drive are Exudyn's; the film force enters as a user function of a
connector, as an Exudyn user would add it. Only films: Exudyn's time steps do not stop at the start
of a contact.
"""

import math
import time

import numpy as np
from clearance.paper_figures.peers import Problem, Solution

from clearance.accuracy.horizon import NotSolved
from clearance.elements import ClearanceRevolute, Drive
from clearance.elements.body import Body, ground
from clearance.laws.film import film_torques
from clearance.laws.law import DataLaw

STEPS = (1000, 4000, 16_000, 64_000)  # a turn
SPECTRAL_RADIUS = 0.9


class Exudyn:
    """A peer of `clearance work-precision`, built anew for each solution, for Exudyn keeps its
    state; a step over a turn stands for the tolerance.
    """

    rtols = tuple(1.0 / steps for steps in STEPS)

    def __init__(self, problem: Problem):
        import exudyn

        scene = problem.scene
        other = [
            type(load).__name__
            for load in scene.loads
            if not isinstance(load, Drive) or load.speed is None
        ]
        if problem.contacts or other or not all(isinstance(d.target, Body) for d in scene.loads):
            raise NotSolved("built here for films and constant-speed cranks only")
        if any(isinstance(j.film.law, DataLaw) for j in scene.clearance_joints):
            raise NotSolved(
                "gets films by formula only: a table looked up in Python would be no fair rival"
            )
        self.exu = exudyn

    def __call__(self, problem: Problem, rtol: float) -> Solution:
        step = rtol * (problem.scene.turn or problem.until)
        intervals = problem.times.size - 1
        count = max(math.ceil(problem.until / step / intervals), 1) * intervals
        model = _Model(self.exu, problem)
        began = time.thread_time()
        model.solve(problem.until, count)
        seconds = time.thread_time() - began
        return Solution(model.states(count // intervals), seconds, count, 0)


class _Model:
    """One Exudyn system of a scene."""

    def __init__(self, exu, problem: Problem):
        from exudyn import itemInterface

        self.exu, self.items, self.problem = exu, itemInterface, problem
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.bodies, self.nodes = {ground: self.mbs.AddObject(itemInterface.ObjectGround())}, {}
        self.sensors = {}
        for body in problem.scene.bodies:
            self._body(body)
        for joint in problem.scene.joints:
            self._joint(joint)
        for drive in problem.scene.loads:
            self._drive(drive)
        self.mbs.Assemble()

    def _body(self, body: Body) -> None:
        start, items = self.problem.mechanism.start, self.items
        node = self.mbs.AddNode(
            items.NodeRigidBody2D(
                referenceCoordinates=list(start.pose[body]),
                initialVelocities=list(start.velocity[body]),
            )
        )
        self.nodes[body] = node
        self.bodies[body] = self.mbs.AddObject(
            items.ObjectRigidBody2D(mass=body.mass, inertia=body.inertia, nodeNumber=node)
        )
        if any(self.problem.scene.gravity):
            marker = self.mbs.AddMarker(items.MarkerBodyMass(bodyNumber=self.bodies[body]))
            self.mbs.AddLoad(
                items.LoadMassProportional(
                    markerNumber=marker, loadVector=[*self.problem.scene.gravity[:2], 0]
                )
            )

    def _marker(self, point) -> int:
        position = [point.x - point.body.com[0], point.y - point.body.com[1], 0.0]
        return self.mbs.AddMarker(
            self.items.MarkerBodyRigid(bodyNumber=self.bodies[point.body], localPosition=position)
        )

    def _joint(self, joint) -> None:
        markers = [self._marker(joint.a), self._marker(joint.b)]
        if joint.soft:
            self._film(joint, markers)
        elif joint.slides:
            x, y = joint.axis
            c, s = math.cos(joint.angle), math.sin(joint.angle)
            # of the axis, in the frame of b, turned by `angle`
            normal = [-c * y + s * x, s * y + c * x, 0.0]
            self.mbs.AddObject(
                self.items.ObjectJointPrismatic2D(
                    markerNumbers=markers, axisMarker0=[x, y, 0.0], normalMarker1=normal
                )
            )
        else:
            self.mbs.AddObject(self.items.ObjectJointRevolute2D(markerNumbers=markers))

    def _drive(self, drive: Drive) -> None:
        items = self.items
        still = self.mbs.AddNode(items.NodePointGround())
        a = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=still, coordinate=0))
        b = self.mbs.AddMarker(
            items.MarkerNodeCoordinate(nodeNumber=self.nodes[drive.target], coordinate=2)
        )
        speed = drive.speed
        self.mbs.AddObject(
            items.ObjectConnectorCoordinate(
                markerNumbers=[a, b],
                offsetUserFunction=lambda mbs, t, number, offset: speed * t,
                offsetUserFunction_t=lambda mbs, t, number, offset: speed,
            )
        )

    def _film(self, joint: ClearanceRevolute, markers: list[int]) -> None:
        exu, items = self.exu, self.items
        law, numbers = joint.film.law.function, joint.film.numbers
        torques = {}

        def omega(body):
            if body is ground:
                return 0.0
            return self.mbs.GetNodeOutput(self.nodes[body], exu.OutputVariableType.AngularVelocity)[
                2
            ]

        def force(mbs, t, number, displacement, velocity, *unused):
            ex, ey = displacement[0], displacement[1]
            e = max(math.hypot(ex, ey), 1e-9 * joint.clearance)
            nx, ny = ex / e, ey / e
            radial, across = (
                (velocity[0] * nx + velocity[1] * ny),
                (velocity[1] * nx - velocity[0] * ny),
            )
            bearing, journal = omega(joint.a.body), omega(joint.b.body)
            entrainment = journal + bearing - 2.0 * across / e
            fr, ft = law(
                e / joint.clearance, radial / joint.clearance, entrainment, joint, *numbers
            )
            if joint.film_torques:
                torques["journal"], torques["bearing"] = film_torques(
                    e / joint.clearance,
                    ft,
                    journal,
                    bearing,
                    joint.radius,
                    joint.clearance,
                    joint.length,
                    joint.viscosity,
                )
            return [-(fr * nx - ft * ny), -(fr * ny + ft * nx), 0.0]

        self.mbs.AddObject(
            items.ObjectConnectorCartesianSpringDamper(
                markerNumbers=markers, springForceUserFunction=force
            )
        )
        if joint.film_torques:
            for marker, which in zip(markers, ("bearing", "journal"), strict=True):
                self.mbs.AddLoad(
                    items.LoadTorqueVector(
                        markerNumber=marker,
                        loadVectorUserFunction=lambda mbs, t, load, which=which: [
                            0.0,
                            0.0,
                            torques.get(which, 0.0),
                        ],
                    )
                )
        self.sensors[joint] = [
            self.mbs.AddSensor(
                items.SensorMarker(
                    markerNumber=m,
                    storeInternal=True,
                    outputVariableType=exu.OutputVariableType.Position,
                )
            )
            for m in markers
        ]

    def solve(self, end: float, count: int) -> None:
        settings = self.exu.SimulationSettings()
        settings.timeIntegration.endTime = end
        settings.timeIntegration.numberOfSteps = count
        settings.timeIntegration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
        settings.timeIntegration.newton.useModifiedNewton = True
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = end / (self.problem.times.size - 1)
        try:
            done = self.mbs.SolveDynamic(settings, showHints=False)
        except Exception as error:  # Exudyn raises plain exceptions of several kinds
            raise NotSolved(str(error).splitlines()[0]) from error
        if done is False:
            raise NotSolved("Newton's method did not converge")

    def states(self, every: int) -> np.ndarray:
        """Eccentricities in the columns where they are compared, zeros elsewhere."""
        y = np.zeros((self.problem.times.size, self.problem.mechanism.y0.size))
        columns = list(self.problem.compared)
        for i, joint in enumerate(self.problem.mechanism.eccentric):
            a, b = (self.mbs.GetSensorStoredData(s) for s in self.sensors[joint])
            if len(a) != len(y) or not np.isfinite(b).all():
                return np.full_like(y, np.nan)
            y[:, columns[2 * i : 2 * i + 2]] = (b - a)[:, 1:3]
        return y
