"""What allantools says, one answer line for each line of input.

deviations FILE FACTOR ...   overlapping Allan and Hadamard deviation of the rates in FILE, which are
                             little-endian doubles at 1 Hz, at averaging times of FACTOR samples
freedom POINTS FACTOR ALPHA  degrees of freedom for noise of slope ALPHA by the simple formulas
interval EDF CONFIDENCE      ends of the interval of a unit deviation
noise FILE B SEED SAMPLES    writes rates whose angle has noise of slope B, and says the Allan
                             deviation that theory gives them at one sample

Numbers are written in digits that read back to the same bits.
"""

import sys
import warnings

import numpy

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import allantools


def deviations(path, *factors):
    rates = numpy.fromfile(path, dtype="<f8")
    taus = [float(factor) for factor in factors]
    answer = []
    # Without data_type the rates would be taken for phases.
    for deviation in (allantools.oadev, allantools.ohdev):
        used, found, _, _ = deviation(rates, rate=1.0, data_type="freq", taus=taus)
        assert list(used) == taus, f"{used} is not {taus}"
        answer.extend(found)
    return answer


def freedom(points, factor, alpha):
    return [allantools.edf_simple(int(points), int(factor), int(alpha))]


def interval(edf, confidence):
    return allantools.confidence_interval(1.0, float(edf), float(confidence))


def noise(path, b, seed, samples):
    numpy.random.seed(int(seed))
    made = allantools.Noise(nr=int(samples), qd=1.0, b=int(b))
    made.generateNoise()
    numpy.diff(made.time_series, prepend=0.0).astype("<f8").tofile(path)
    return [made.adev(1.0, 1.0)]


ANSWERS = {"deviations": deviations, "freedom": freedom, "interval": interval, "noise": noise}


def main():
    for line in sys.stdin:
        asked, *words = line.rstrip("\n").split("\t")
        print(*(repr(float(number)) for number in ANSWERS[asked](*words)), flush=True)


main()
