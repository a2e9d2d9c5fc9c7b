# SPDX-License-Identifier: BSD-3-Clause
"""A small class-agnostic instance segmenter with FastSAM's outputs.

One score, a box and mask coefficients per cell of three grids (strides 8, 16, 32), and prototypes of
masks at a quarter of the input's size [Bolya et al., YOLACT, 2019; Tian et al., FCOS, 2019].
"""
import torch
from torch import nn
from torch.nn import functional

STRIDES = (8, 16, 32)
NUM_PROTOTYPES = 32
HEAD_CHANNELS = 64
BOX_GROWTH = 1.1  # masks are cut off at their boxes: a box that is a little too large does less harm


class Convolution(nn.Module):
    def __init__(self, inputs, outputs, size=3, stride=1):
        super().__init__()
        self.convolution = nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False)
        self.norm = nn.BatchNorm2d(outputs)

    def forward(self, x):
        return functional.relu(self.norm(self.convolution(x)), inplace=True)


class Stage(nn.Module):
    """Part of the channels goes through residual pairs of convolutions; all are then mixed."""

    def __init__(self, inputs, outputs, depth):
        super().__init__()
        half = outputs // 2
        self.split = Convolution(inputs, outputs, 1)
        self.pairs = nn.ModuleList(
            nn.Sequential(Convolution(half, half), Convolution(half, half)) for _ in range(depth))
        self.mix = Convolution(outputs + depth * half, outputs, 1)

    def forward(self, x):
        kept, last = self.split(x).chunk(2, 1)
        parts = [kept, last]
        for pair in self.pairs:
            last = last + pair(last)
            parts.append(last)
        return self.mix(torch.cat(parts, 1))


class Context(nn.Module):
    """Sees far: maxima over growing windows."""

    def __init__(self, channels):
        super().__init__()
        half = channels // 2
        self.reduce = Convolution(channels, half, 1)
        self.mix = Convolution(4 * half, channels, 1)

    def forward(self, x):
        parts = [self.reduce(x)]
        for _ in range(3):
            parts.append(functional.max_pool2d(parts[-1], 5, 1, 2))
        return self.mix(torch.cat(parts, 1))


def upsample(x):
    return functional.interpolate(x, scale_factor=2.0, mode="nearest")


class Segmenter(nn.Module):
    """Input RGB in 0..1 [N,3,H,W], sides multiples of 32. `origin_px`: row of the 384 px square at
    which a training image that is not square begins."""

    def __init__(self, size=384):
        super().__init__()
        self.size = size
        self.stem = nn.Sequential(Convolution(3, 16, 3, 2), Convolution(16, 32, 3, 2))
        self.stage4 = Stage(32, 32, 1)
        self.stage8 = nn.Sequential(Convolution(32, 64, 3, 2), Stage(64, 64, 1))
        self.stage16 = nn.Sequential(Convolution(64, 96, 3, 2), Stage(96, 96, 2))
        self.stage32 = nn.Sequential(Convolution(96, 128, 3, 2), Stage(128, 128, 1), Context(128))
        self.down16 = Stage(128 + 96, 96, 1)
        self.down8 = Stage(96 + 64, 64, 1)
        self.up16 = nn.Sequential(Convolution(64 + 96, 96, 1))
        self.join8 = Convolution(64, 64, 3, 2)
        self.inputs = nn.ModuleList(Convolution(c, HEAD_CHANNELS, 1) for c in (64, 96, 128))
        self.tower = nn.Sequential(Convolution(HEAD_CHANNELS, HEAD_CHANNELS),
                                   Convolution(HEAD_CHANNELS, HEAD_CHANNELS))
        self.score = nn.Conv2d(HEAD_CHANNELS, 1, 1)
        self.box = nn.Conv2d(HEAD_CHANNELS, 4, 1)
        self.coefficients = nn.Conv2d(HEAD_CHANNELS, NUM_PROTOTYPES, 1)
        self.prototype_reduce = Convolution(64, 32, 1)
        self.prototype_mix = Convolution(32 + 2, 32)
        self.prototypes = nn.Conv2d(32, NUM_PROTOTYPES, 1)
        nn.init.constant_(self.score.bias, -4.0)

    def compute_pyramid(self, x):
        p4 = self.stage4(self.stem(x))
        p8 = self.stage8(p4)
        p16 = self.stage16(p8)
        p32 = self.stage32(p16)
        q16 = self.down16(torch.cat((upsample(p32), p16), 1))
        q8 = self.down8(torch.cat((upsample(q16), p8), 1))
        r16 = self.up16(torch.cat((self.join8(q8), q16), 1))
        return p4, (q8, r16, p32)

    def make_grid(self, height, width, stride, origin_px, like):
        """Centres of cells in pixels, [2, height, width]: x, y."""
        x = (torch.arange(width, device=like.device, dtype=torch.float32) + 0.5) * stride
        y = (torch.arange(height, device=like.device, dtype=torch.float32) + 0.5) * stride + origin_px
        return torch.stack((x[None, :].expand(height, width), y[:, None].expand(height, width)))

    def compute_prototypes(self, p4, q8, origin_px):
        x = p4 + upsample(self.prototype_reduce(q8))
        grid = self.make_grid(x.shape[2], x.shape[3], 4, origin_px, x) / (0.5 * self.size) - 1.0
        grid = grid.to(x.dtype)[None].expand(x.shape[0], -1, -1, -1)
        return self.prototypes(self.prototype_mix(torch.cat((x, grid), 1)))

    def compute_raw(self, x, origin_px=0):
        """Per cell: boxes x0 y0 x1 y1 in pixels of the input [N,A,4], score logits [N,A], mask
        coefficients [N,A,K]; prototypes [N,K,H/4,W/4]; centres [A,2] and strides [A] of the cells."""
        p4, levels = self.compute_pyramid(x)
        boxes, scores, coefficients, centers, strides = [], [], [], [], []
        for stride, reduce, level in zip(STRIDES, self.inputs, levels):
            features = self.tower(reduce(level))
            grid = self.make_grid(level.shape[2], level.shape[3], stride, 0, level).flatten(1).t()
            reach = functional.softplus(self.box(features).flatten(2).transpose(1, 2).float())
            reach = reach * (2.0 * stride)
            boxes.append(torch.cat((grid - reach[..., :2], grid + reach[..., 2:]), -1))
            scores.append(self.score(features).flatten(1).float())
            coefficients.append(self.coefficients(features).flatten(2).transpose(1, 2).float())
            centers.append(grid)
            strides.append(torch.full((grid.shape[0],), float(stride), device=x.device))
        prototypes = self.compute_prototypes(p4, levels[0], origin_px)
        return (torch.cat(boxes, 1), torch.cat(scores, 1), torch.cat(coefficients, 1), prototypes,
                torch.cat(centers), torch.cat(strides))

    def forward(self, images):
        """FastSAM's signature: [N,37,A] (cx cy w h, score, 32 coefficients), [N,32,S/4,S/4]."""
        boxes, scores, coefficients, prototypes, _, _ = self.compute_raw(images)
        corner, end = boxes[..., :2], boxes[..., 2:]
        columns = torch.cat((0.5 * (corner + end), BOX_GROWTH * (end - corner),
                             scores.sigmoid()[..., None], coefficients), -1)
        return columns.transpose(1, 2), prototypes
