"""The judge: what the lecture's rules answer in exact arithmetic, pixel by pixel.

What is judged. The exact answer is that of the rules S1–S6, S8–S12 and S14–S16 on the scene's
float64 numbers: screen, vertices, centres, radii, light, ε. It is certain, and minirt must have
it, where it stays the same whichever way every step is blurred by what minirt promises of its
own rounding: 4 ulp of each number that goes into a step and of each that comes out of it, or of
the terms that it is the sum of. So a ball that straddles a decision leaves it open, and a tie is
open: no float64 program could be held to it.

How. Balls of python-flint's `arb` carry the blur from the screen to the last ray; no formula is
shared with minirt. t itself is compared with the exact one, in rationals up to the square root of
S8, in ulp of its condition number. Other numbers are compared with the middle of their ball, in
quarters of its radius.
"""

from reference.exact.choice import pixels_to_judge as pixels_to_judge
from reference.exact.judge import JUDGED as JUDGED
from reference.exact.judge import Judgement as Judgement
from reference.exact.judge import Opinion as Opinion
from reference.exact.judge import judge_pixels as judge_pixels
