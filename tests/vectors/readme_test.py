#!/usr/bin/env python3
"""Runs the snippet of README.md: it must accept the right model and see wrong ones."""
import json
import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import generate
from models import DEon, KajiyaKay, Marschner
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


def older(model, name, angles, **wrong):
    """Misses of a model of models.py, and of one with other parameters."""
    path = os.path.join(generate.HERE, name)
    with open(path, encoding='utf-8') as file:
        columns = json.load(file)['inputs']

    def call(row, changes):
        x = {c: int(v) if c in ('lobes', 'printed') else mpf(v) for c, v in row.items()}
        parameters = {}
        for c in columns:
            for group, suffixes in generate.SUFFIXES.items():
                if c in ['%s_%s' % (group, s) for s in suffixes]:
                    parameters.setdefault(group, []).append(x[c])
                    break
            else:
                if c not in angles:
                    parameters[c] = x[c]
        parameters.update({name: change(parameters[name]) for name, change in changes.items()})
        return model(**parameters).evaluate(*[x[a] for a in angles])
    return len(misses(path, lambda row: call(row, {}), 2.0**-53)), len(misses(path, lambda row: call(row, wrong)))


path = os.path.join(generate.HERE, 'bsdf.json')
right = misses(path, evaluate, 2.0**-53)
tilted = misses(path, lambda row: evaluate(row, tilt=-1))
diameters = misses(path, lambda row: evaluate(row, chord=1))
print('misses: %d of the model, %d of the other tilt, %d of sigma_a per diameter' % (len(right), len(tilted), len(diameters)))
fine = not right and len(tilted) > 100 and len(diameters) > 100
for what, (of_right, of_wrong) in {
        'Kajiya and Kay, exponent 1 too large': older(KajiyaKay, 'kajiya_kay.json', ['theta_o', 'theta_i'], exponent=lambda n: n + 1),
        'Marschner, as printed and mended exchanged': older(Marschner, 'marschner.json', ['theta_o', 'theta_i', 'phi_o', 'phi_i'],
                                                            printed=lambda p: 1 - p),
        "d'Eon, shifts of theta_h": older(DEon, 'deon_near.json', ['theta_o', 'theta_i', 'phi'], alpha=lambda a: [x / 2 for x in a]),
}.items():
    print('misses: %d of the model, %d of %s' % (of_right, of_wrong, what))
    fine = fine and not of_right and of_wrong > 100
sys.exit(0 if fine else 1)
