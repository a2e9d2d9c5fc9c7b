# SPDX-License-Identifier: BSD-3-Clause
"""Contrastive training of the dual encoder."""
import random

import numpy as np
import torch
from torch import distributed
from torch.nn import functional

from . import vocabulary
from .encoder_network import VOCABULARY_SIZE, ImageEncoder, TextEncoder
from .segmenter_training import Average, descend, disturb_colors, set_rate

ALPHA = 0.23  # cosine that the loss puts between what fits and what does not
SIGMOID_SCALE = 16.0
NUM_ABSENT_TEXTS = 24
IMAGE_MEAN, IMAGE_STD = 0.5, 0.25
CONTEXT = 77


class Tokenizer:
    """CLIP's, from the package open_clip_torch (needed for training only)."""

    def __init__(self):
        from open_clip.tokenizer import SimpleTokenizer
        self.encoder = SimpleTokenizer()
        self.known = {}

    def encode(self, sentences):
        result = np.zeros((len(sentences), CONTEXT), np.int64)
        for row, sentence in zip(result, sentences):
            if sentence not in self.known:
                self.known[sentence] = self.encoder.encode(sentence)[:CONTEXT - 2]
            tokens = self.known[sentence]
            row[0] = VOCABULARY_SIZE - 2
            row[1:1 + len(tokens)] = tokens
            row[1 + len(tokens)] = VOCABULARY_SIZE - 1
        return torch.from_numpy(result)


def find_tokens(tokenizer, phrases):
    """All tokens of the sentences that are trained on, ascending."""
    found = set()
    for sentence in list(phrases) + vocabulary.list_sentences():
        found.update(tokenizer.encoder.encode(sentence))
    return sorted(found)


def is_true(text, phrase, color, room):
    if text.absent or (room != "") != (text.rooms is not None):
        return False
    if room != "":
        return room in text.rooms
    if text.classes is not None and phrase not in text.classes:
        return False
    return text.color is None or text.color == vocabulary.color_of(phrase, color)


def draw_texts(rng, crops, batch):
    """Sentences, each true of some image of the batch or of none; and which is true of which."""
    texts = {}
    for i in batch:
        room = crops.rooms[i]
        own = ([vocabulary.describe_room(rng, room)] if room
               else vocabulary.describe_apart(rng, crops.phrases[i], crops.colors[i]))
        texts.update((text.sentence, text) for text in own)
    for _ in range(NUM_ABSENT_TEXTS):
        text = vocabulary.describe_nothing(rng)
        texts.setdefault(text.sentence, text)
    texts = list(texts.values())
    truth = np.array([[is_true(t, crops.phrases[i], crops.colors[i], crops.rooms[i])
                       for t in texts] for i in batch])
    return [t.sentence for t in texts], torch.from_numpy(truth)


def compute_loss(cosines, truth, scale):
    """CLIP's contrastive loss with several true texts per image, both ways; and the same against the
    constant ALPHA: what fits is to lie above it, everything else together below."""
    logits = scale * cosines
    margin = SIGMOID_SCALE * (cosines - ALPHA)
    loss = functional.softplus(-margin)[truth].mean()
    for dim in (0, 1):
        others = logits.masked_fill(truth, -1e4).logsumexp(dim, keepdim=True)
        loss = loss + functional.softplus(others - logits)[truth].mean()
        above = margin.masked_fill(truth, -1e4).logsumexp(dim)
        loss = loss + 0.5 * functional.softplus(above).mean()
    return loss


def zoom(pairs, generator):
    """Cuts up to a quarter off each crop's sides, as boxes of segmenters do, or adds a little black."""
    size = 0.74 + 0.32 * torch.rand(len(pairs), 2, generator=generator)
    shift = (1 - size).abs() * (2 * torch.rand(len(pairs), 2, generator=generator) - 1)
    mirrored = 1 - 2 * (torch.rand(len(pairs), generator=generator) < 0.5).float()
    transform = torch.zeros(len(pairs), 2, 3)
    transform[:, 0, 0], transform[:, 1, 1] = size[:, 0] * mirrored, size[:, 1]
    transform[:, :, 2] = shift
    grid = functional.affine_grid(transform, list(pairs.shape), align_corners=False)
    return functional.grid_sample(pairs, grid, align_corners=False)


def load_images(crops, batch, generator):
    """[B, 2, 3, 64, 64], normalised; black stays black."""
    pairs = [crops.images[i].reshape(-1, *crops.images.shape[3:]) for i in batch]
    images = disturb_colors(pairs, generator)  # pairs share a table
    n, _, _, size = images.shape
    images = images.reshape(n, 3, 2, size, size).permute(0, 2, 1, 3, 4)
    images = zoom(images.reshape(n, 6, size, size), generator)
    return ((images - IMAGE_MEAN) / IMAGE_STD).reshape(n, 2, 3, size, size)


def embed_pairs(encoder, images):
    """Unit mean of the embeddings of both crops, as the segmenter makes it."""
    n = images.shape[0]
    flat = images.reshape(-1, *images.shape[2:]).contiguous(memory_format=torch.channels_last)
    vectors = encoder(flat).float().reshape(n, 2, -1)
    return functional.normalize(vectors.mean(1), dim=1)


def make_order(crops, rng):
    """One pass, in which kinds of things count by the root of their number, rooms thrice."""
    kinds = [p or r for p, r in zip(crops.phrases, crops.rooms)]
    names, counts = np.unique(kinds, return_counts=True)
    frequency = dict(zip(names, counts))
    weights = np.array([(3 if r else 1) * frequency[k] ** -0.5 for k, r in zip(kinds, crops.rooms)])
    return rng.choice(len(kinds), len(kinds), p=weights / weights.sum())


def make_networks(tokens):
    networks = torch.nn.ModuleDict({"image": ImageEncoder(), "text": TextEncoder(tokens)})
    networks.register_parameter("scale", torch.nn.Parameter(torch.tensor(2.7)))  # its logarithm
    return networks.to(memory_format=torch.channels_last)


def train(crops, output, schedule, seed, batch_size=128, peak_rate=2e-3, resume=False):
    """Saves the averaged weights and the list of tokens to `output` once a minute and at the end.
    `resume`, several processes: as the segmenter's."""
    rank = distributed.get_rank() if distributed.is_initialized() else 0
    torch.manual_seed(seed)
    rng, order = random.Random(1000 * seed + rank), np.random.default_rng(1000 * seed + rank)
    generator = torch.Generator().manual_seed(1000 * seed + rank)
    tokenizer = Tokenizer()
    tokens = find_tokens(tokenizer, sorted({p for p in crops.phrases if p}))
    networks = make_networks(tokens)
    if resume:
        networks.load_state_dict(torch.load(output, weights_only=True)["state"])
    optimizer = torch.optim.AdamW(networks.parameters(), peak_rate, weight_decay=0.02)
    average = Average(networks)
    step, saved_s, queue, recent = 0, 0.0, [], []
    while (share := schedule.share(step)) < 1.0:
        if len(queue) < batch_size:
            queue = make_order(crops, order).tolist()
        batch, queue = queue[:batch_size], queue[batch_size:]
        sentences, truth = draw_texts(rng, crops, batch)
        images = load_images(crops, batch, generator)
        set_rate(optimizer, share, peak_rate)
        with torch.autocast("cpu", torch.bfloat16):
            vectors = embed_pairs(networks["image"], images)
        texts = networks["text"](tokenizer.encode(sentences))
        scale = networks.scale.exp().clamp(max=50.0)
        loss = compute_loss(vectors @ texts.t(), truth, scale)
        descend(loss, networks, optimizer, 5.0)
        average.update(networks)
        step += 1
        recent.append(loss.item())
        if rank == 0 and step % 50 == 0:
            print(f"[encoder] step {step} ({share:.0%}) {schedule.elapsed_s():.0f} s, loss "
                  f"{np.mean(recent):.3f}, scale {scale.item():.1f}", flush=True)
            recent = []
        if rank == 0 and schedule.elapsed_s() - saved_s > 60:
            saved_s = schedule.elapsed_s()
            torch.save({"state": average.state, "tokens": tokens}, output)
    if rank == 0:
        torch.save({"state": average.state, "tokens": tokens}, output)
