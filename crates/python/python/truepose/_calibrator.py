"""A fit in scikit-learn's manners."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from truepose._arrays import Floats, floats
from truepose._core import InputError
from truepose._data import Measurements, measurements
from truepose._effect import Model
from truepose._fit import Fit
from truepose._robot import Robot
from truepose._verbs import identify


class Calibrator:
    """Calibration with `fit`, `predict`, `score`, `get_params` and `set_params`, for scikit-learn's cross-validation and grid searches.

    ``X`` are joint values n × dof (rad or m) and ``y`` positions n × 3 (m); or ``X`` is a table with the headers of files, or `Measurements`, and
    ``y`` is None. `score` is minus the RMS of the 3-D position error, m: larger is better. After `fit`, the fit is `fit_`.

    Examples
    --------
    >>> scores = cross_val_score(tp.Calibrator(robot), q, position, groups=poses, cv=GroupKFold(5))
    """

    def __init__(self, robot: Robot | None = None, model: Model = None, solver: str = "qr", prior: str | float = "evidence") -> None:
        self.robot = robot
        self.model = model
        self.solver = solver
        self.prior = prior

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters of the constructor."""
        return {"robot": self.robot, "model": self.model, "solver": self.solver, "prior": self.prior}

    def set_params(self, **params: Any) -> Calibrator:
        """Sets parameters of the constructor."""
        for key, value in params.items():
            if key not in self.get_params():
                raise ValueError(f"unknown parameter {key!r} (known: {', '.join(self.get_params())})")
            setattr(self, key, value)
        return self

    def __sklearn_clone__(self) -> Calibrator:
        return Calibrator(**self.get_params())

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import RegressorTags, Tags, TargetTags  # type: ignore[import-untyped,unused-ignore]

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=False, multi_output=True),
            regressor_tags=RegressorTags(),
        )

    def fit(self, X: Any, y: ArrayLike | None = None, *, groups: ArrayLike | None = None) -> Calibrator:
        """Fits. With `groups` (one label for each row) the fit is cross-validated over them as well: ``fit_.held_out``."""
        rows = self._rows(X, y)
        self.fit_: Fit = identify(
            self._robot(), rows, model=self.model, solver=self.solver, prior=self.prior, folds=0, groups=groups
        )
        self.n_features_in_ = self._robot().dof
        return self

    def predict(self, X: Any) -> Floats:
        """Positions n × 3, m."""
        return self._fitted().predict(X).position

    def score(self, X: Any, y: ArrayLike | None = None) -> float:
        """Minus the RMS of the 3-D position error, m."""
        if y is None:
            return -self._fitted().residuals_of(X if isinstance(X, Measurements) else measurements(self._robot(), X)).rms
        predicted = self.predict(X)
        away = np.linalg.norm(predicted - floats("y", y, len(predicted), 3), axis=1)
        known = away[np.isfinite(away)]
        return -float(np.sqrt(np.mean(known**2))) if known.size else float("nan")

    def _robot(self) -> Robot:
        if self.robot is None:
            raise InputError("a Calibrator needs a robot: tp.Calibrator(robot)")
        return self.robot

    def _fitted(self) -> Fit:
        if not hasattr(self, "fit_"):
            raise InputError("the Calibrator has not been fitted: call fit first")
        return self.fit_

    def _rows(self, X: Any, y: ArrayLike | None) -> Measurements:
        if isinstance(X, Measurements):
            return X
        if y is None:
            return measurements(self._robot(), X)
        return measurements(self._robot(), q=X, position=y)

    def __repr__(self) -> str:
        return f"Calibrator({', '.join(f'{key}={value!r}' for key, value in self.get_params().items())})"
