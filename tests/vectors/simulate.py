#!/usr/bin/env python3
"""Tables of the fiber simulator with error bars, written to simulator.json beside this file.

    simulate.py CUTICLE [SAMPLES]     CUTICLE: the program; rays for each fiber (default 600000)

The simulator traces rays through an explicit fiber (src/fibers/fiber_simulator.h) and is itself held against exact solutions
by its tests. The same seed gives the same file.
"""
import csv
import json
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROWS, COLUMNS = 8, 12
# As options of `cuticle goniometer`; angles in degrees
FIBERS = [
    {'eta': 1.55, 'sigma_a': 0.2, 'theta_i': 30},
    {'eta': 1.55, 'sigma_a': 0.2, 'theta_i': 30, 'alpha': 3, 'roughness': 0.12},
    {'eta': 1.55, 'sigma_a': 0.1, 'theta_i': -20, 'phi_i': 40, 'axis_ratio': 0.8, 'roughness': 0.1},
    {'eta': 1.4, 'sigma_a': 0.3, 'theta_i': 60, 'alpha': 2, 'roughness': 0.25, 'distribution': 'ggx'},
]
CLASSES = ('R', 'TT', 'TRT', 'rest')


def simulate(cuticle, fiber, samples):
    """The rows (class, row, column, density, error) and the energies (class, energy, error) of one fiber."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'fiber.csv')
        options = [x for name, value in fiber.items() for x in ('--' + name.replace('_', '-'), str(value))]
        said = subprocess.run([cuticle, 'goniometer', *options, '--samples', str(samples), '--orders', '3', '--cells', str(ROWS),
                               str(COLUMNS), '--equal-solid-angle', '--plane', 'hemisphere', '-o', path],
                              check=True, capture_output=True, text=True).stdout
        with open(path, encoding='utf-8') as file:
            file.readline()  # the parameters
            cells = {name: [] for name in CLASSES}
            for line in csv.DictReader(file):
                if line['class'] in cells:
                    cells[line['class']].append((float(line['density_0_per_sr']), float(line['error_0_per_sr'])))
    table = [[CLASSES.index(name), i // COLUMNS, i % COLUMNS, *pair] for name, pairs in cells.items() for i, pair in enumerate(pairs)]
    energy = [[CLASSES.index(name), float(value), float(error)]
              for name, value, error in re.findall(r'^\s+(\w+)\s+([\d.]+) ± ([\d.]+)$', said, re.M) if name in CLASSES]
    return table, energy


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    samples = int(sys.argv[2]) if len(sys.argv) == 3 else 600000
    rows, energies = [], []
    for k, fiber in enumerate(FIBERS):
        table, energy = simulate(sys.argv[1], fiber, samples)
        assert len(table) == len(CLASSES) * ROWS * COLUMNS and len(energy) == len(CLASSES)
        rows += [[k, *row] for row in table if row[3] > 0]
        energies += [[k, *row] for row in energy]
    head = {
        'format': 'cuticle hair vectors', 'version': 1,
        'quantity': 'Where an explicit fiber sends light: the share of what meets it, per steradian, for uniform light over its width',
        'made_by': 'tests/vectors/simulate.py, cuticle goniometer, %d rays a fiber, seed 1' % samples,
        'inputs': ['fiber', 'path', 'i', 'j'], 'outputs': ['density'],
        'notes': ['fiber: index into fibers (options of cuticle goniometer; sigma_a per radius, angles in degrees; light from theta_i, phi_i)',
                  'path: 0 R, 1 TT, 2 TRT, 3 all further orders',
                  'i: step of %d of sin theta from -1 to 1; j: step of %d of phi from -pi to pi; the mean over the cell' % (ROWS, COLUMNS),
                  'error: one standard error; cells that no ray met are left out',
                  'energies: fiber, path, share of all light, one standard error'],
        'samples': samples, 'fibers': FIBERS, 'energies': energies,
    }
    text = json.dumps(head)[:-1] + ',\n"columns": ["fiber", "path", "i", "j", "density", "error"],\n"rows": [\n'
    text += ',\n'.join(json.dumps(row, separators=(',', ':')) for row in rows) + '\n]}\n'
    path = os.path.join(HERE, 'simulator.json')
    with open(path + '.new', 'w', encoding='utf-8') as file:
        file.write(text)
    os.replace(path + '.new', path)
    print('wrote simulator.json: %d bytes, %d rows' % (len(text), len(rows)))


if __name__ == '__main__':
    main()
