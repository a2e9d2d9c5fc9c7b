# SPDX-License-Identifier: BSD-3-Clause
"""A small dual encoder: crops and sentences to unit vectors in one space."""
import numpy as np
import torch
from torch import nn
from torch.nn import functional

EMBEDDING_SIZE = 128
VOCABULARY_SIZE = 49408  # of CLIP's tokenizer
PADDING, UNKNOWN, FIRST_WORD = 0, 1, 2  # rows of the table of embeddings


class Block(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.first = nn.Conv2d(channels, channels, 3, 1, 1, bias=False)
        self.first_norm = nn.BatchNorm2d(channels)
        self.second = nn.Conv2d(channels, channels, 3, 1, 1, bias=False)
        self.second_norm = nn.BatchNorm2d(channels)

    def forward(self, x):
        y = functional.relu(self.first_norm(self.first(x)))
        return functional.relu(x + self.second_norm(self.second(y)))


def reduce(inputs, outputs, size=3):
    return nn.Sequential(nn.Conv2d(inputs, outputs, size, 2, size // 2, bias=False),
                         nn.BatchNorm2d(outputs), nn.ReLU())


class ImageEncoder(nn.Module):
    """[N,3,64,64] (normalised) -> [N,128] of unit length."""

    def __init__(self):
        super().__init__()
        self.body = nn.Sequential(
            reduce(3, 32, 5), reduce(32, 48), Block(48), reduce(48, 96), Block(96), reduce(96, 192),
            Block(192))
        self.hidden = nn.Linear(2 * 192, 384)
        self.output = nn.Linear(384, EMBEDDING_SIZE)

    def forward(self, images):
        x = self.body(images)
        x = torch.cat((x.mean((2, 3)), x.amax((2, 3))), 1)
        return functional.normalize(self.output(functional.relu(self.hidden(x))), dim=1)


class TextEncoder(nn.Module):
    """CLIP's tokens int64 [N,77] -> [N,128] of unit length. Words that were not trained on share one
    embedding. The order of words is not looked at: a sentence is a weighted mean of its words, the
    weights learned ("get", "the": little), then a small network."""

    def __init__(self, tokens, width=96):
        super().__init__()
        table = np.full(VOCABULARY_SIZE, UNKNOWN, np.int16)
        table[[0, VOCABULARY_SIZE - 2, VOCABULARY_SIZE - 1]] = PADDING  # padding, start, end
        table[list(tokens)] = np.arange(FIRST_WORD, FIRST_WORD + len(tokens))
        self.register_buffer("row_of_token", torch.from_numpy(table.astype(np.int32)))
        self.words = nn.Embedding(FIRST_WORD + len(tokens), width)
        self.weight = nn.Embedding(FIRST_WORD + len(tokens), 1)
        nn.init.normal_(self.words.weight, std=1.0)
        nn.init.zeros_(self.weight.weight)
        self.hidden = nn.Linear(width, 256)
        self.mixed = nn.Linear(256, EMBEDDING_SIZE)
        self.direct = nn.Linear(width, EMBEDDING_SIZE)

    def forward(self, tokens):
        rows = self.row_of_token[tokens].to(torch.int64)
        is_word = (rows != PADDING).float()
        share = is_word * torch.exp(self.weight(rows)[..., 0])
        mean = (self.words(rows) * share[..., None]).sum(1) / (share.sum(1, keepdim=True) + 1e-4)
        result = self.direct(mean) + self.mixed(functional.relu(self.hidden(mean)))
        return functional.normalize(result, dim=1)
