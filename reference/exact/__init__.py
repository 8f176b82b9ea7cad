"""The judge: the answers of the lecture's rules in exact arithmetic, pixel by pixel.

What is judged. The exact answer is that of rules S1–S6, S8–S12 and S14–S16 on the scene's float64
numbers: screen, vertices, centres, radii, light, ε. minirt promises a rounding error of each step:
4 ulp of each input and of each output, or of the terms of which the output is the sum. The exact
answer is certain, and minirt must give it, if no combination of such errors changes it. If a ball
(see below) contains both sides of a decision, the answer is open; so is a tie. No float64 program
could be held to an open answer.

How. Ball arithmetic (python-flint's `arb`) carries these errors from the screen to the last ray;
no formula is shared with minirt. t is compared with the exact one, computed in rationals up to the
square root of S8, in ulp times its condition number. Other numbers are compared with the middle of
their ball, in quarters of its radius.
"""

from reference.exact.judge import JUDGED as JUDGED
from reference.exact.judge import Judgement as Judgement
from reference.exact.judge import Opinion as Opinion
from reference.exact.judge import judge_pixels as judge_pixels
from reference.exact.sampling import pixels_to_judge as pixels_to_judge
