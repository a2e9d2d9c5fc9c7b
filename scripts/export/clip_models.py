# SPDX-License-Identifier: BSD-3-Clause
"""CLIP models out of open_clip or OpenAI's clip, whichever the user has."""
import collections
import pathlib

import checks
import networks

Choice = collections.namedtuple("Choice", "open_clip_name default_weights openai_name alpha")

# alpha: the threshold on cosines that the paper uses with the model; None: nobody measured one.
CHOICES = {
    "vit-b-32": Choice("ViT-B-32", "openai", "ViT-B/32", 0.23),
    "vit-l-14": Choice("ViT-L-14", "openai", "ViT-L/14", 0.23),
    "vit-h-14": Choice("ViT-H-14", "laion2b_s32b_b79k", None, 0.26),
    "mobileclip2-s0": Choice("MobileCLIP2-S0", "dfndr2b", None, None),
}


def find_choice(name, weights):
    """One of CHOICES, or any architecture of open_clip by its own name."""
    if name.lower() in CHOICES:
        return CHOICES[name.lower()]
    if not weights:
        raise SystemExit("--clip is '%s', expected one of %s, or open_clip's name of another one together with --clip-weights"
                         % (name, ", ".join(sorted(CHOICES))))
    return Choice(name, weights, None, None)


TEXTS = ["a photo of a red mug", "get the notes and books from the desk", "", "!?", "wash the dishes", "ein Stuhl",
         "the dog's bowl, 2 of them", "kitchen", "somewhere to sit", "word " * 100]


class Source:
    """A loaded model: what exporting and checking needs, whatever package it is from.

    `preprocess` maps a PIL image to a tensor, `tokenize` a list of texts to int tokens [n, 77].
    """

    def __init__(self, model, package, preprocess, tokenize, settings, vocabulary):
        self.model, self.package = model, package
        self.preprocess, self.tokenize = preprocess, tokenize
        self.settings, self.vocabulary = settings, vocabulary

    def towers(self):
        import torch

        class ImageTower(torch.nn.Module):
            def __init__(self, model):
                super().__init__()
                self.model = model

            def forward(self, images):
                return self.model.encode_image(images)

        class TextTower(torch.nn.Module):
            def __init__(self, model):
                super().__init__()
                self.model = model

            def forward(self, text):
                return self.model.encode_text(text)

        return ImageTower(self.model).eval(), TextTower(self.model).eval()


def load(choice, weights, package, random_weights, images):
    """Loads a model; `package` is 'open_clip', 'clip' or None for the first that is there."""
    if package in (None, "open_clip"):
        try:
            import open_clip  # noqa: F401
            return load_open_clip(choice, weights, random_weights, images)
        except ImportError as error:
            if package or choice.openai_name is None:
                raise SystemExit("open_clip cannot be imported (pip install open_clip_torch): %s" % error)
    if choice.openai_name is None:
        raise SystemExit("OpenAI's clip has no %s, use open_clip" % choice.open_clip_name)
    return load_openai(choice, weights, random_weights)


def load_open_clip(choice, weights, random_weights, views):
    import open_clip
    import torch
    from open_clip.pretrained import get_pretrained_cfg
    weights = weights or choice.default_weights
    known = get_pretrained_cfg(choice.open_clip_name, weights) or {}
    name = choice.open_clip_name
    # Weights that were trained with another activation than the architecture's default one.
    if known.get("quick_gelu") and name + "-quickgelu" in open_clip.list_models():
        name += "-quickgelu"
    preprocessing = {"image_mean": known.get("mean"), "image_std": known.get("std"),
                     "image_interpolation": known.get("interpolation")}
    model, _, preprocess = open_clip.create_model_and_transforms(
        name, pretrained=None if random_weights else weights, **preprocessing)
    model = model.float().eval()
    if random_weights:
        networks.calibrate_batch_norm(model.visual, torch.stack([preprocess(view) for view in views]))
    config = open_clip.get_model_preprocess_cfg(model)
    size = config["size"][0] if isinstance(config["size"], (tuple, list)) else config["size"]
    settings = {"mean": list(config["mean"]), "std": list(config["std"]), "size": size,
                "interpolation": config.get("interpolation"), "weights": "random" if random_weights else weights, "name": name}
    vocabulary = pathlib.Path(open_clip.__file__).parent / "bpe_simple_vocab_16e6.txt.gz"
    return Source(model, "open_clip " + open_clip.__version__, preprocess, open_clip.get_tokenizer(name), settings, vocabulary)


def load_openai(choice, weights, random_weights):
    try:
        import clip
        from clip.clip import _transform
    except ImportError as error:
        raise SystemExit("neither open_clip nor OpenAI's clip can be imported (pip install open_clip_torch): %s" % error)
    if random_weights:
        model = build_random_openai(clip, choice.openai_name)
        preprocess = _transform(model.visual.input_resolution)
    else:
        model, preprocess = clip.load(weights or choice.openai_name, device="cpu", jit=False)
    settings = {"mean": [0.48145466, 0.4578275, 0.40821073], "std": [0.26862954, 0.26130258, 0.27577711],
                "size": model.visual.input_resolution, "interpolation": "bicubic",
                "weights": "random" if random_weights else weights or "openai", "name": choice.openai_name}
    vocabulary = pathlib.Path(clip.__file__).parent / "bpe_simple_vocab_16e6.txt.gz"
    return Source(model.float().eval(), "clip", preprocess, lambda texts: clip.tokenize(texts, truncate=True), settings, vocabulary)


def build_random_openai(clip, name):
    from clip.model import CLIP
    sizes = {"ViT-B/32": (512, 224, 12, 768, 32, 77, 49408, 512, 8, 12), "ViT-L/14": (768, 224, 24, 1024, 14, 77, 49408, 768, 12, 12)}
    return CLIP(*sizes[name])


def require_our_tokenizer(source):
    """Our programs have CLIP's own tokenizer only: other ones (SigLIP, ...) are refused."""
    import gzip
    tokens = source.tokenize(["A red mug.", ""]).tolist()
    expected = [[49406, 320, 736, 9722, 269, 49407] + 71 * [0], [49406, 49407] + 75 * [0]]
    if tokens != expected:
        raise checks.Mismatch("the model's tokenizer is not CLIP's: 'A red mug.' becomes %s" % tokens[0][:8])
    with gzip.open(str(source.vocabulary)) as file:
        if not file.readline():
            raise checks.Mismatch("the vocabulary %s is empty" % source.vocabulary)


def reparameterize(model):
    """Merges the branches that some architectures (MobileCLIP) have for training only."""
    if not any(hasattr(module, "reparameterize") for module in model.modules()):
        return model
    from timm.utils import reparameterize_model
    return reparameterize_model(model)


def export(source, views, folder, stem):
    """Writes and checks both towers. Returns their file names, the embedding size and what was found."""
    import torch
    image_tower, text_tower = source.towers()
    images = torch.stack([source.preprocess(view) for view in views])
    tokens = source.tokenize(TEXTS).to(torch.int64)
    with torch.no_grad():
        expected_images, expected_texts = image_tower(images).numpy(), text_tower(tokens).numpy()
    image_tower.model = reparameterize(source.model)
    image_path, text_path = folder / (stem + "_image.onnx"), folder / (stem + "_text.onnx")
    networks.export(image_tower, images[:2], "images", "embedding", image_path)
    networks.export(text_tower, tokens[:2], "text", "embedding", text_path)
    findings = [
        checks.compare_embeddings("image encoder", expected_images, checks.run_onnx(image_path, images.numpy())[0]),
        checks.compare_embeddings("text encoder", expected_texts, checks.run_onnx(text_path, tokens.numpy())[0]),
    ]
    return image_path.name, text_path.name, expected_texts, findings
