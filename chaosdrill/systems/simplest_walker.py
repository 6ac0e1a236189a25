"""Two massless legs, a heavy hip and light feet on a slope: the simplest walking model.

    theta'' = sin(theta - gamma)
    phi'' = sin(theta - gamma) + (theta'^2 - cos(theta - gamma)) sin phi
    at heel strike, phi = 2 theta:  theta := -theta, theta' := cos(2 theta) theta', phi := -2 theta,
                                    phi' := cos(2 theta) (1 - cos(2 theta)) theta'

The swing leg may pass through the ground near the vertical, as in the source: Garcia, Chatterjee, Ruina and Coleman
1998, doi:10.1115/1.2798313.
"""

from chaosdrill.declared import event

NAME = "simplest-walker"
SUMMARY = "simplest walker on a slope"
GROUP = "walkers"
STATES = {
    "theta": "angle of the stance leg",
    "omega": "angular velocity of the stance leg",
    "phi": "angle between the legs",
    "psi": "rate of the angle between the legs",
}
PARAMETERS = {
    "gamma": (0.009, "slope"),
}
EQUATIONS = {
    "modes": {
        "stance": {
            "theta": "omega",
            "omega": "sin(theta - gamma)",
            "phi": "psi",
            "psi": "sin(theta - gamma) + (omega**2 - cos(theta - gamma))*sin(phi)",
        }
    },
    "transitions": [
        event(
            "heel-strike",
            "stance",
            "stance",
            guard="phi - 2*theta",
            direction=+1,
            reset={
                "theta": "-theta",
                "omega": "cos(2*theta)*omega",
                "phi": "-2*theta",
                "psi": "cos(2*theta)*(1 - cos(2*theta))*omega",
            },
            condition="theta < 0",
            kind="impact",
        )
    ],
    "initial": {"mode": "stance", "theta": 0.2, "omega": -0.2, "phi": 0.4, "psi": -0.016},
}
"""The walker with default parameters, started near its gait."""
