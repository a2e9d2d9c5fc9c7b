# SPDX-License-Identifier: BSD-3-Clause
"""Worlds x levels of segments x methods -> results, a report and a figure. Resumes where it stopped:
what lies in the output folder is not made again."""
import argparse
import collections
import os
import sys

from . import chain, figures, methods, report, results, study, worlds

# duration_s: of the walk, 0: until every room has been seen.
Suite = collections.namedtuple("Suite", "worlds seeds levels duration_s")
SUITES = {
    "smoke": Suite(["apartment"], [1], ["clip_like"], 12.0),
    "small": Suite(["apartment"], [1], ["none", "clip_like"], 0.0),
    "full": Suite(list(worlds.KINDS), [1, 2, 3, 4, 5], list(worlds.LEVELS), 0.0),
}


def say(text):
    print(f"[benchmark] {text}", flush=True)


def parse_arguments():
    parser = argparse.ArgumentParser(
        prog="scripts/benchmark",
        description="Scores this package and its baselines against worlds with a known truth. "
                    "Writes results, report.md, report.png and curves.png; goes on where it was stopped.")
    parser.add_argument("--output", default="output/benchmark", help="folder (output/benchmark)")
    parser.add_argument("--suite", choices=sorted(SUITES), default="small",
                        help="smoke: the first seconds of one apartment; small: one apartment, two "
                             "levels (default); full: five of each world, both task lists, three levels")
    parser.add_argument("--house", action="append", default=[],
                        help="folder of a rendered house with labels, embeddings and truth; "
                             "may be given several times")
    parser.add_argument("--worlds", nargs="*", choices=worlds.KINDS, help="not the suite's")
    parser.add_argument("--seeds", type=int, nargs="*", help="of the worlds, not the suite's")
    parser.add_argument("--levels", nargs="+", choices=worlds.LEVELS, help="not the suite's")
    parser.add_argument("--methods", nargs="+", default=methods.find_default_names(),
                        help="rows of the table (all but clio_online, which takes as long as the walk): " +
                             "; ".join(f"{m.name}: {m.text}" for m in methods.METHODS))
    parser.add_argument("--study", action="store_true",
                        help="not methods but parameters, one at a time around the defaults: study.md, "
                             "study.json, study.png")
    parser.add_argument("--parameters", nargs="+", default=[p.name for p in study.PARAMETERS],
                        help="of the study (all): " + ", ".join(p.name for p in study.PARAMETERS))
    parser.add_argument("--compare", metavar="FOLDER",
                        help="results of an earlier run: adds what changed since to the report")
    arguments = parser.parse_args()
    try:
        arguments.methods = methods.find_methods(arguments.methods)
        arguments.parameters = study.find_parameters(arguments.parameters)
    except ValueError as error:
        parser.error(str(error))
    suite = SUITES[arguments.suite]
    arguments.worlds = suite.worlds if arguments.worlds is None else arguments.worlds
    arguments.seeds = suite.seeds if arguments.seeds is None else arguments.seeds
    arguments.levels = arguments.levels or suite.levels
    arguments.duration_s = suite.duration_s
    return arguments


def score_list(run, recording, number, level, arguments):
    """One of the recording's lists of tasks. Maps that do not depend on tasks are made once."""
    tasks = recording.lists[number]
    shared = os.path.join(arguments.output, recording.name)
    folder = os.path.join(shared, "coarse") if number > 0 else shared
    for method in arguments.methods:
        path = os.path.join(folder, f"{method.name}.result.json")
        if os.path.exists(path):
            continue
        uses_tasks = methods.FRONT_ENDS[method.front_end].uses_tasks
        map_folder = chain.make_map(run, recording, tasks.tasks, method.front_end,
                                    folder if uses_tasks else shared)
        os.makedirs(folder, exist_ok=True)
        scores = chain.evaluate(run, recording, tasks, map_folder,
                                os.path.join(folder, f"{method.name}.scores.json"), method.layer,
                                method.keep)
        stages = chain.read_stage_times(map_folder)
        results.write(path, {"world": tasks.world, "level": level, "recording": recording.name,
                             "method": method.name, "scores": scores, "stages": stages,
                             "ms_per_frame": sum(stages.values()) if stages else None,
                             "frames": chain.read_frames(map_folder)})
        strict = scores["paper"]["strict"]
        say(f"{tasks.world}, {recording.name} {method.name}: strict F1 {strict['f1']:.3f} "
            f"(osR {strict['recall']:.3f}, osP {strict['precision']:.3f})")


def study_list(run, recording, number, level, arguments):
    """As score_list(), one parameter at a time."""
    shared = os.path.join(arguments.output, recording.name)
    folder = os.path.join(shared, "coarse") if number > 0 else shared
    for parameter in arguments.parameters:
        study.score(run, recording, recording.lists[number], level, parameter, folder, say)


def list_recordings(run, arguments):
    """(recording, seed) of each; prepared one by one, so that results come early."""
    bags = os.path.join(arguments.output, "bags")
    os.makedirs(bags, exist_ok=True)
    for house in arguments.house:
        house = os.path.abspath(os.path.expanduser(house))
        yield worlds.prepare_house(run, bags, house), 1
    for kind in arguments.worlds:
        for seed in arguments.seeds:
            yield worlds.prepare_world(run, bags, kind, seed, arguments.duration_s), seed


def make_command():
    return "scripts/benchmark " + " ".join(sys.argv[1:])


def write_report(arguments):
    found = results.load_all(arguments.output)
    text = report.make_report(found, make_command())
    if arguments.compare:
        before = results.load_all(arguments.compare)
        text += f"\n## Since {arguments.compare}\n\n{report.compare(before, found)}\n"
    path = os.path.join(arguments.output, "report.md")
    with open(path + ".part", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".part", path)
    drawn = figures.draw(found, arguments.output)
    say(f"{path}: {len(found)} results; " +
        (", ".join(drawn) if drawn else "no figures without python3-matplotlib"))


def main():
    arguments = parse_arguments()
    root = os.environ["TSG_ROOT"]
    os.makedirs(arguments.output, exist_ok=True)
    run = chain.Runner(root, os.path.join(arguments.output, "log.txt"))
    try:
        for recording, seed in list_recordings(run, arguments):
            for level in arguments.levels:
                degraded = worlds.degrade(run, recording, level, seed)
                for number in range(len(recording.lists)):
                    (study_list if arguments.study else score_list)(run, degraded, number, level,
                                                                    arguments)
        if arguments.study:
            study.write_report(arguments.output, make_command(), say)
        else:
            write_report(arguments)
    except (RuntimeError, ValueError, OSError) as error:
        print(f"scripts/benchmark: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
