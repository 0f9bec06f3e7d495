"""Any number of Kalman filters in one record, updated by the tracker's kernels."""

from luxloop.tracker.tracking.filters import correct_rows, predict_rows


class Filters:
    """Kalman filters of n states each, in an array of any shape; measurements are of the first states.

    Means are (..., n) and covariances (..., n, n).
    """

    def __init__(self, mean, covariance):
        self.mean, self.covariance = mean, covariance

    def predict(self, step):
        """Move on by one time step."""
        self._set_rows(*predict_rows(*self._rows(), matrices(step.transition), matrices(step.noise)))

    def correct(self, residual, noise):
        """Correct by innovations (..., m) of the first m states, 1 or 2, with noise (m, m) or (..., m, m)."""
        rows = residual.reshape(-1, residual.shape[-1])
        self._set_rows(*correct_rows(*self._rows(), rows, matrices(noise)))

    def _rows(self):
        return self.mean.reshape(-1, self.mean.shape[-1]), matrices(self.covariance)

    def _set_rows(self, mean, covariance):
        self.mean, self.covariance = mean.reshape(self.mean.shape), covariance.reshape(self.covariance.shape)


def matrices(array):
    """(K, n, n) matrices of an array (..., n, n)."""
    return array.reshape(-1, *array.shape[-2:])
