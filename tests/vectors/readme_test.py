#!/usr/bin/env python3
"""Runs the snippet of README.md: it must accept the right model and see wrong ones."""
import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import generate
from mpmath import mpf

with open(os.path.join(generate.HERE, 'README.md'), encoding='utf-8') as file:
    SNIPPET = re.search(r'```python\n(.*?)```', file.read(), re.S).group(1)
exec(SNIPPET)


def evaluate(row, tilt=1, chord=2):
    """The model; tilt -1: the scales' other way; chord 1: sigma_a per diameter."""
    x = {name: mpf(value) for name, value in row.items()}
    sigma = [chord / mpf(2) * x[c] for c in ('sigma_r', 'sigma_g', 'sigma_b')]
    fiber = generate.Fiber(x['h'], x['eta'], sigma, x['beta_m'], x['beta_n'], x['alpha'], tilt * x['tilt'])
    return fiber.evaluate(x['theta_o'], x['theta_i'], x['phi'])


path = os.path.join(generate.HERE, 'bsdf.json')
right = misses(path, evaluate, 2.0**-53)
tilted = misses(path, lambda row: evaluate(row, tilt=-1))
diameters = misses(path, lambda row: evaluate(row, chord=1))
print('misses: %d of the model, %d of the other tilt, %d of sigma_a per diameter' % (len(right), len(tilted), len(diameters)))
sys.exit(0 if not right and len(tilted) > 100 and len(diameters) > 100 else 1)
