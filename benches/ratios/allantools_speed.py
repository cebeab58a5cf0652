"""The overlapping Allan deviation by allantools, timed on request.

Arguments: a file of little-endian doubles, which are rates at 1 Hz, and averaging times in samples.
Says "allantools VERSION", or "missing" when it is not installed. Then, for every line, calculates
all deviations and answers with the wall time in seconds and their sum.
"""

import sys
import time
import warnings

try:
    import numpy

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import allantools
except ImportError:
    print("missing", flush=True)
    sys.exit()


def main():
    print("allantools", allantools.__version__, flush=True)
    rates = numpy.fromfile(sys.argv[1], dtype="<f8")
    taus = [float(factor) for factor in sys.argv[2:]]
    for _ in sys.stdin:
        begun = time.perf_counter()
        _, deviations, _, _ = allantools.oadev(rates, rate=1.0, data_type="freq", taus=taus)
        taken_s = time.perf_counter() - begun
        print(taken_s, repr(float(deviations.sum())), flush=True)


main()
