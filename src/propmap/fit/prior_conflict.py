"""Whether the constants that a fit found are at odds with those of other propellers."""

from __future__ import annotations

import numpy as np

from propmap.catalogue.identified import PARAMETERS
from propmap.fit.fitted import Fitted

FAR = 2.5
"""Standard deviations from what propellers let expect, from which a constant is worth a remark."""


def doubts_on_constants(fitted: Fitted) -> list[str]:
    """Constants that lie far from those of other propellers, in one sentence; mostly nothing.

    Parameters
    ----------
    fitted : Fitted
        The fit; without a prior over propellers there is nothing to compare with.
    """
    expected = fitted.choice.expected
    if expected is None:
        return []
    apart = np.abs(expected.apart(fitted.values)[0])
    own = {**fitted.choice.fixed, **fitted.choice.priors}
    far = [
        f"{name} is {fitted.values[name]:.3g}, {apart[k]:.1f} standard deviations from what "
        "propellers let expect"
        for k, name in enumerate(PARAMETERS)
        if apart[k] > FAR and name not in own
    ]
    if not far:
        return []
    return [f"{'; '.join(far)}: check the blade's twist, the radius, the units and the density"]
