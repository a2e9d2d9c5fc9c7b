# SPDX-License-Identifier: BSD-3-Clause
"""Which cells answer for which thing, and what their answers cost.

Cells: task-aligned assignment [Feng et al., TOOD, 2021]: for each thing the ten cells inside its box
whose score and box fit it best. Boxes: generalised IoU. Masks: cross entropy inside the box and Dice.
"""
import torch
from torch.nn import functional

CELLS_PER_THING = 10
SCORE_POWER, IOU_POWER = 0.5, 6.0
BOX_WEIGHT, SCORE_WEIGHT, MASK_WEIGHT, DICE_WEIGHT = 4.0, 1.0, 2.5, 2.0
MAX_MASKS = 40  # cells per image whose masks are trained


def compute_iou(a, b):
    """IoU and generalised IoU of boxes that broadcast."""
    low = torch.maximum(a[..., :2], b[..., :2])
    high = torch.minimum(a[..., 2:], b[..., 2:])
    common = (high - low).clamp(min=0).prod(-1)
    area_a = (a[..., 2:] - a[..., :2]).clamp(min=0).prod(-1)
    area_b = (b[..., 2:] - b[..., :2]).clamp(min=0).prod(-1)
    union = area_a + area_b - common + 1e-6
    hull = (torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])).prod(-1)
    iou = common / union
    return iou, iou - (hull - union) / (hull + 1e-6)


@torch.no_grad()
def assign(boxes, score_logits, centers, strides, targets):
    """Of one image: index of the thing of each cell (-1: none) and the score it should have."""
    num_cells = boxes.shape[0]
    owner = torch.full((num_cells,), -1, dtype=torch.int64)
    wanted = torch.zeros(num_cells)
    if targets.shape[0] == 0:
        return owner, wanted
    iou, _ = compute_iou(targets[:, None], boxes[None])
    # A small thing may hold no cell's centre: half a cell around its box counts, too.
    reach = 0.5 * strides[None, :, None] * (
        (targets[:, None, 2:] - targets[:, None, :2]) < 2 * strides[None, :, None])
    inside = ((centers[None] > targets[:, None, :2] - reach) &
              (centers[None] < targets[:, None, 2:] + reach)).all(-1)
    fit = score_logits.sigmoid()[None].pow(SCORE_POWER) * iou.pow(IOU_POWER) * inside + 1e-9 * inside
    best = fit.topk(min(CELLS_PER_THING, num_cells), 1)
    chosen = torch.zeros_like(fit).scatter_(1, best.indices, (best.values > 0).float()).bool()
    shared_iou = torch.where(chosen, iou + 1e-6, torch.zeros_like(iou))
    value, thing = shared_iou.max(0)
    taken = value > 0
    owner[taken] = thing[taken]
    mine = torch.where(chosen, fit, torch.zeros_like(fit))
    highest = mine.max(1, keepdim=True).values + 1e-12
    best_iou = torch.where(chosen, iou, torch.zeros_like(iou)).max(1, keepdim=True).values
    normalised = mine / highest * best_iou
    wanted[taken] = normalised[thing[taken], taken.nonzero()[:, 0]]
    return owner, wanted


def compute_mask_loss(logits, truth, boxes):
    """Of cells [M,H,W] against masks, inside boxes given in cells of the prototypes."""
    height, width = logits.shape[1:]
    x = torch.arange(width)[None, None] + 0.5
    y = torch.arange(height)[None, :, None] + 0.5
    x0, y0, x1, y1 = (boxes[:, i, None, None] for i in range(4))
    inside = ((x > x0 - 1) & (x < x1 + 1) & (y > y0 - 1) & (y < y1 + 1)).float()
    area = inside.sum((1, 2)).clamp(min=1)
    entropy = functional.binary_cross_entropy_with_logits(logits, truth, reduction="none")
    entropy = (entropy * inside).sum((1, 2)) / area
    share = logits.sigmoid() * inside
    dice = 1 - (2 * (share * truth).sum((1, 2)) + 1) / (share.sum((1, 2)) + truth.sum((1, 2)) + 1)
    return entropy, dice


def compute_image_loss(raw, index, things, labels, generator):
    """Loss parts of one image: score, box, mask, dice sums and the sum of wanted scores."""
    boxes, scores, coefficients, prototypes, centers, strides = raw
    boxes, scores, coefficients = boxes[index], scores[index], coefficients[index]
    is_target = things[:, 4] > 0
    target_index = is_target.nonzero()[:, 0]
    targets = things[target_index, :4]
    owner, wanted = assign(boxes.detach(), scores.detach(), centers, strides, targets)
    ignored = torch.cat((torch.zeros(1, dtype=torch.bool), ~is_target))  # by label
    under = labels[centers[:, 1].to(torch.int64), centers[:, 0].to(torch.int64)].to(torch.int64)
    weight = 1.0 - (ignored[under] & (owner < 0)).float()
    score_loss = (functional.binary_cross_entropy_with_logits(scores, wanted, reduction="none")
                  * weight).sum()
    cells = (owner >= 0).nonzero()[:, 0]
    if len(cells) == 0:
        zero = scores.sum() * 0
        return score_loss, zero, zero, zero, wanted.sum()
    _, giou = compute_iou(boxes[cells], targets[owner[cells]])
    box_loss = ((1 - giou) * wanted[cells]).sum()
    if len(cells) > MAX_MASKS:
        cells = cells[torch.randperm(len(cells), generator=generator)[:MAX_MASKS]]
    small = labels[2::4, 2::4].to(torch.int64)
    truth = (small[None] == (target_index[owner[cells]] + 1)[:, None, None]).float()
    logits = torch.einsum("mk,khw->mhw", coefficients[cells], prototypes[index].float())
    entropy, dice = compute_mask_loss(logits, truth, targets[owner[cells]] / 4)
    share = wanted[owner >= 0].sum() / wanted[cells].sum().clamp(min=1e-6)
    return (score_loss, box_loss, (entropy * wanted[cells]).sum() * share,
            (dice * wanted[cells]).sum() * share, wanted.sum())


def compute_loss(raw, things, labels, generator):
    """Total loss of a batch and its parts (score, box, mask, dice)."""
    parts = [compute_image_loss(raw, i, things[i], labels[i], generator) for i in range(len(things))]
    sums = [torch.stack(column).sum() for column in zip(*parts)]
    total = sums[4].clamp(min=1.0)
    score, box, mask, dice = (s / total for s in sums[:4])
    loss = SCORE_WEIGHT * score + BOX_WEIGHT * box + MASK_WEIGHT * mask + DICE_WEIGHT * dice
    return loss, tuple(float(v.detach()) for v in (score, box, mask, dice))
