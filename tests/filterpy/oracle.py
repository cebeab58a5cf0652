"""What FilterPy believes after each step, one answer line for each line of steps.

The first line of input names the filter: the period of its torsion in seconds or "rotation", start
angle and rate, their variances, the measurement's variance, the density of white angular
acceleration. Every further line is a step: its span, and the rate measured at its end or "gap".

An answer is angle, rate, the covariance's elements (angle, cross, rate), the innovation and its
variance, 0 in a gap. Transition and noise are FilterPy's too, by Van Loan's exponential.
Numbers are written in digits that read back to the same bits.
"""

import math
import sys

import numpy
from filterpy.common import van_loan_discretization
from filterpy.kalman import KalmanFilter


def main():
    asked = sys.stdin.readlines()
    motion, *numbers = asked[0].split()
    angle, rate, angle_variance, rate_variance, r, q = map(float, numbers)
    omega = 0.0 if motion == "rotation" else 2.0 * math.pi / float(motion)
    dynamics = numpy.array([[0.0, 1.0], [-omega * omega, 0.0]])
    noise = numpy.array([[0.0], [math.sqrt(q)]])
    judge = KalmanFilter(dim_x=2, dim_z=1)
    judge.x = numpy.array([[angle], [rate]])
    judge.P = numpy.diag([angle_variance, rate_variance])
    judge.H = numpy.array([[0.0, 1.0]])
    judge.R = numpy.array([[r]])
    for line in asked[1:]:
        span, measured = line.split()
        judge.F, judge.Q = van_loan_discretization(dynamics, noise, float(span))
        judge.predict()
        innovation, variance = 0.0, 0.0
        if measured != "gap":
            judge.update(float(measured))
            innovation, variance = judge.y[0, 0], judge.S[0, 0]
        (a, b), (_, c) = judge.P
        answer = [judge.x[0, 0], judge.x[1, 0], a, b, c, innovation, variance]
        print(*(repr(float(number)) for number in answer))


main()
