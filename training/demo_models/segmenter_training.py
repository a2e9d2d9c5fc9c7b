# SPDX-License-Identifier: BSD-3-Clause
"""Training of the segmenter."""
import math
import time

import numpy as np
import torch
from torch import distributed

from .data import CONTENT_ROWS, SEGMENTER_SIZE
from .segmenter_loss import compute_loss
from .segmenter_network import Segmenter

GREY = 114 / 255
FEW_ROWS = 320  # of the 384: for speed, most of the training leaves out padding
ALL_ROWS_FROM = 0.9  # share of the training from which on it does not


def make_color_table(generator):
    """8-bit value -> 0..1 per channel [3,256], for a random exposure, white balance and gamma: little
    enough that colours keep their names."""
    gain = 0.85 + 0.3 * torch.rand(1, generator=generator)
    balance = 1.0 + 0.04 * (2 * torch.rand(3, 1, generator=generator) - 1)
    gamma = torch.exp(0.1 * torch.randn(1, generator=generator))
    return (torch.linspace(0, 1, 256)[None] * gain * balance).clamp(0.0, 1.0).pow(gamma).numpy()


def disturb_colors(images, generator):
    """8-bit images [N,H,W,3] as another camera would have taken them, [N,3,H,W] in 0..1."""
    result = np.empty((len(images), 3) + images[0].shape[:2], np.float32)
    for image, to in zip(images, result):
        table = make_color_table(generator)
        for channel in range(3):
            np.take(table[channel], image[..., channel], out=to[channel])
    result = torch.from_numpy(result)
    noise = 0.03 * float(torch.rand(1, generator=generator)) - 0.01
    if noise > 0:
        result += noise * torch.randn(result.shape, generator=generator)
    return result.clamp_(0.0, 1.0)


def make_batch(views, indices, num_rows, generator):
    """Images [N,3,num_rows,384], labels [N,num_rows,384], things (boxes in pixels of these)."""
    content = disturb_colors([views.images[i] for i in indices], generator)
    images = torch.full((len(indices), 3, num_rows, SEGMENTER_SIZE), GREY)
    margin = (num_rows - CONTENT_ROWS) // 2
    rows = slice(margin, margin + CONTENT_ROWS)
    images[:, :, rows] = content
    labels = torch.zeros(len(indices), num_rows, SEGMENTER_SIZE, dtype=torch.uint8)
    things = []
    for k, i in enumerate(indices):
        labels[k, rows] = torch.from_numpy(views.labels[i].copy())
        boxes = torch.from_numpy(views.things[i].copy())
        boxes[:, [1, 3]] += margin
        if torch.rand(1, generator=generator) < 0.5:
            images[k] = images[k].flip(-1)
            labels[k] = labels[k].flip(-1)
            boxes[:, [0, 2]] = SEGMENTER_SIZE - boxes[:, [2, 0]]
        things.append(boxes)
    return images.contiguous(memory_format=torch.channels_last), labels, things


class Average:
    """Running mean of the weights, which is what is exported."""

    def __init__(self, network, decay=0.998):
        self.decay = decay
        self.steps = 0
        self.state = {k: v.detach().clone() for k, v in network.state_dict().items()}

    def update(self, network):
        self.steps += 1
        decay = min(self.decay, (1 + self.steps) / (10 + self.steps))
        for name, value in network.state_dict().items():
            if value.dtype.is_floating_point:
                self.state[name].lerp_(value.detach(), 1 - decay)
            else:
                self.state[name].copy_(value)


def descend(loss, network, optimizer, max_norm):
    """One step, with the mean gradient of all processes if there are several."""
    optimizer.zero_grad()
    loss.backward()
    if distributed.is_initialized():
        gradients = [p.grad for p in network.parameters()]
        flat = torch.cat([g.flatten() for g in gradients])
        distributed.all_reduce(flat)
        flat /= distributed.get_world_size()
        for gradient, part in zip(gradients, flat.split([g.numel() for g in gradients])):
            gradient.copy_(part.reshape(gradient.shape))
    torch.nn.utils.clip_grad_norm_(network.parameters(), max_norm)
    optimizer.step()


def set_rate(optimizer, share, peak):
    """Warm-up over the first 4 %, then a cosine to a hundredth."""
    factor = share / 0.04 if share < 0.04 else 0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * share))
    for group in optimizer.param_groups:
        group["lr"] = peak * factor


class Schedule:
    """Share of the training that is over: by steps, or by time where that is further."""

    def __init__(self, steps, limit_min=None):
        self.steps = steps
        self.limit_s = 60 * limit_min if limit_min else float("inf")
        self.start = time.monotonic()

    def elapsed_s(self):
        return time.monotonic() - self.start

    def share(self, step):
        share = torch.tensor(max(step / self.steps, self.elapsed_s() / self.limit_s))
        if distributed.is_initialized():
            distributed.broadcast(share, 0)
        return float(share)


def train(views, output, schedule, seed, batch_size=8, peak_rate=2e-3, resume=False):
    """Saves the averaged weights to `output` once a minute and at the end. `resume`: begins with what
    is there. In several processes (torch.distributed), each takes a batch of its own."""
    rank = distributed.get_rank() if distributed.is_initialized() else 0
    torch.manual_seed(seed)
    network = Segmenter(SEGMENTER_SIZE).to(memory_format=torch.channels_last)
    if resume:
        network.load_state_dict(torch.load(output, weights_only=True))
    generator = torch.Generator().manual_seed(1000 * seed + rank)
    order = np.random.default_rng(1000 * seed + rank)
    optimizer = torch.optim.AdamW(network.parameters(), peak_rate, weight_decay=0.02)
    average = Average(network)
    step, saved_s, queue, recent = 0, 0.0, [], []
    while (share := schedule.share(step)) < 1.0:
        if len(queue) < batch_size:
            queue = order.permutation(len(views.things)).tolist()
        batch, queue = queue[:batch_size], queue[batch_size:]
        num_rows = FEW_ROWS if share < ALL_ROWS_FROM else SEGMENTER_SIZE
        images, labels, things = make_batch(views, sorted(batch), num_rows, generator)
        set_rate(optimizer, share, peak_rate)
        with torch.autocast("cpu", torch.bfloat16):
            raw = network.compute_raw(images, (SEGMENTER_SIZE - num_rows) // 2)
        loss, parts = compute_loss(raw, things, labels, generator)
        descend(loss, network, optimizer, 10.0)
        average.update(network)
        step += 1
        recent.append(parts)
        if rank == 0 and step % 50 == 0:
            print(f"[segmenter] step {step} ({share:.0%}) {schedule.elapsed_s():.0f} s, "
                  "score/box/mask/dice " + " ".join(f"{v:.3f}" for v in np.mean(recent, 0)), flush=True)
            recent = []
        if rank == 0 and schedule.elapsed_s() - saved_s > 60:
            saved_s = schedule.elapsed_s()
            torch.save(average.state, output)
    if rank == 0:
        torch.save(average.state, output)
