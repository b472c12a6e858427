#!/usr/bin/env python3
"""random_vgg19.py FILE [raw]: VGG-19 up to conv5_1 with random weights of He's deviation, in half precision, as safetensors.

They are rescaled before use. With `raw` they are taken as they are, have biases, and are such that each of the five layers counts in a Gram
loss with the paper's factors.
"""
import json
import struct
import sys

import numpy as np

RAW = sys.argv[2:] == ["raw"]
GAINS = {(3, 1): 10**0.5, (5, 1): 10**-0.5} if RAW else {}
WIDTHS = {1: (64, 2), 2: (128, 2), 3: (256, 4), 4: (512, 4), 5: (512, 1)}

random = np.random.default_rng(1)
tensors = {}
inputs = 3
for block, (outputs, count) in WIDTHS.items():
    for number in range(1, count + 1):
        weights = random.standard_normal((outputs, inputs, 3, 3)) * np.sqrt(2 / (9 * inputs)) * GAINS.get((block, number), 1)
        tensors[f"conv{block}_{number}.weight"] = weights.astype(np.float16)
        tensors[f"conv{block}_{number}.bias"] = (random.uniform(-10, 10, outputs) if RAW else np.zeros(outputs)).astype(np.float16)
        inputs = outputs
header = {"__metadata__": {"scale": "raw" if RAW else "other"}}
offset = 0
for name, values in tensors.items():
    header[name] = {"dtype": "F16", "shape": list(values.shape), "data_offsets": [offset, offset + values.nbytes]}
    offset += values.nbytes
text = json.dumps(header).encode()
text += b" " * (-len(text) % 8)
with open(sys.argv[1], "wb") as file:
    file.write(struct.pack("<Q", len(text)) + text + b"".join(values.tobytes() for values in tensors.values()))
