"""stf doctor: a sound installation, and installations with one thing broken each."""

import json
import os
import pathlib
import shutil
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["STF_BUILD"])
PLUGINS = pathlib.Path(os.environ["STF_TEST_PLUGINS"])
STF = BUILD / "bin" / "stf"
NONE = ("HDSTF_", "PXR_", "XDG_CACHE_HOME", "LD_LIBRARY_PATH")


def doctor(*options, cwd="/", stf=STF, **variables):
    """Exit code and findings of `stf doctor` with these variables of the environment alone."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(NONE)} | variables
    run = subprocess.run([stf, "doctor", "--json", *map(str, options)], env=environment, cwd=cwd, capture_output=True,
                         text=True)
    told = json.loads(run.stdout)
    assert told["problems"] == sum(f["state"] == "problem" for f in told["findings"])
    assert run.returncode == (1 if told["problems"] else 0), run.stderr
    return told["findings"]


def quick(*options, **others):
    return doctor("--no-render", *options, **others)


def of(findings, state):
    return [f"{f['topic']}: {f['text']} -> {f['todo']}" for f in findings if f["state"] == state]


def one(findings, state, *parts):
    """The only finding of that state; has all parts."""
    lines = of(findings, state)
    assert len(lines) == 1, lines
    for part in parts:
        assert str(part) in lines[0], lines[0]


@pytest.fixture
def tree(tmp_path):
    """A copy of the plugin folder, to break."""
    folder = tmp_path / "plugin"
    shutil.copytree(BUILD / "plugin", folder)
    return folder


def replace_library(tree, name):
    shutil.copy(PLUGINS / name, tree / "hdStf.so")


def test_sound(tree, tmp_path):
    cache = tmp_path / "cache"
    findings = doctor(PXR_PLUGINPATH_NAME=str(tree), HDSTF_CACHE_DIR=str(cache), HDSTF_SAMPLES="4")
    assert not of(findings, "problem")
    lines = "\n".join(of(findings, "ok"))
    for part in (f"{tree}/hdStf.so loads; built for OpenUSD", "namespace pxr", "libraries: TBB", "libraries: Embree",
                 "libraries: OpenVDB", f"cache: {cache}: 0 tables", "free on the disk", "memory: ", "threads: ",
                 "environment: HDSTF_SAMPLES=4", "render: a shell of 8 x 8 pixels took", "schemas: "):
        assert part in lines, part
    assert not cache.exists(), "looking at the cache, and the test picture, leave nothing in it"


def test_lines_for_people():
    environment = {k: v for k, v in os.environ.items() if not k.startswith(NONE)}
    run = subprocess.run([STF, "doctor", "--no-render"], env=environment, capture_output=True, text=True)
    first = run.stdout.splitlines()[0]
    assert run.returncode == 1
    assert first == ("problem  plugin path: PXR_PLUGINPATH_NAME is not set: no host finds the renderer -> export "
                     f"PXR_PLUGINPATH_NAME={BUILD / 'plugin'}")


def test_path_that_is_not_there(tmp_path):
    findings = quick(PXR_PLUGINPATH_NAME=str(tmp_path / "nowhere"))
    problems = of(findings, "problem")
    assert len(problems) == 2
    assert f"{tmp_path}/nowhere in PXR_PLUGINPATH_NAME does not exist" in problems[0]
    assert "no plugInfo.json on the path describes the plugin hdStf" in problems[1]


def test_relative_path(tree):
    findings = quick(cwd=tree.parent, PXR_PLUGINPATH_NAME="plugin")
    problems = of(findings, "problem")
    assert '"plugin" in PXR_PLUGINPATH_NAME is relative' in problems[0]
    assert f"export PXR_PLUGINPATH_NAME={tree}" in problems[0]


def test_entry_that_is_wrong_beside_one_that_is_right(tree, tmp_path):
    findings = quick(PXR_PLUGINPATH_NAME=f"{tmp_path}/nowhere:{tree}")
    one(findings, "problem", "nowhere in PXR_PLUGINPATH_NAME does not exist")


def test_path_of_another_plugin(tree):
    shutil.rmtree(tree / "hdStf")
    one(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem", "no plugInfo.json on the path describes the plugin hdStf")


def test_no_schemas(tree):
    shutil.rmtree(tree / "stfSchemas")
    one(quick(PXR_PLUGINPATH_NAME=str(tree)), "warning", "StfShellAPI is an unknown schema")


def test_folder_without_plug_info(tree):
    (tree / "plugInfo.json").unlink()
    problems = of(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem")
    assert f"{tree}/plugInfo.json cannot be read" in problems[0]


@pytest.mark.parametrize("text, said", [("{ \"Plugins\": [ }", "is no valid JSON: parse error at line 1, column 16"),
                                        ("", "is no valid JSON"), ("[]", "holds no JSON object"),
                                        ("{\"Plugins\": 3}", "has \"Plugins\" that is no list"),
                                        ("{\"Includes\": [3]}", "has an \"Includes\" that is no path")])
def test_corrupt_plug_info(tree, text, said):
    (tree / "hdStf/resources/plugInfo.json").write_text(text)
    problems = of(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem")
    assert f"{tree}/hdStf/resources/plugInfo.json {said}" in problems[0], problems


def test_comments_in_plug_info(tree):
    path = tree / "hdStf/resources/plugInfo.json"
    path.write_text("# as OpenUSD allows\n" + path.read_text())
    assert not of(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem")


def test_plug_info_that_includes_itself(tree):
    (tree / "plugInfo.json").write_text('{"Includes": ["*/resources/", "plugInfo.json", "./"]}')
    assert not of(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem")


def test_library_that_is_not_there(tree):
    (tree / "hdStf.so").unlink()
    one(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem", f"{tree}/hdStf.so", "does not exist")


def test_library_that_is_none(tree):
    (tree / "hdStf.so").write_text("no library")
    one(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem", f"{tree}/hdStf.so cannot be loaded", "install hdStf anew")


def test_function_that_is_missing(tree):
    replace_library(tree, "unresolved.so")
    one(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem",
        "undefined symbol: pxrInternal_v0_99__pxrReserved__::HdRenderDelegate::Commit()",
        "the OpenUSD here is not the one that the plugin was built for")


def test_python_of_the_host(tree):
    """A host has Python in it, a probe has not: no problem, whether this machine has a libpython or not."""
    replace_library(tree, "python.so")
    findings = quick(PXR_PLUGINPATH_NAME=str(tree))
    assert not of(findings, "problem")
    said = "\n".join(of(findings, "ok") + of(findings, "warning"))
    assert "hdStf.so loads (with libpython3." in said or "whose Python its OpenUSD wants" in said, said


def test_library_that_it_needs_is_missing(tree):
    replace_library(tree, "dependent.so")
    absent = PLUGINS / "absent.so"
    hidden = PLUGINS / "hidden.so"
    absent.rename(hidden)
    try:
        one(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem", "absent.so: cannot open shared object file",
            "install what is missing")
    finally:
        hidden.rename(absent)


def test_library_that_ends_the_process(tree):
    replace_library(tree, "aborting.so")
    one(quick(PXR_PLUGINPATH_NAME=str(tree)), "problem", "loading it ends the process: Aborted")


def test_two_of_the_same_name(tree):
    findings = quick(PXR_PLUGINPATH_NAME=f"{tree}:{BUILD / 'plugin'}")
    warnings = of(findings, "warning")
    assert f"plugin hdStf is on the path twice: that of {tree}/hdStf/resources/plugInfo.json counts" in warnings[0]
    assert not of(findings, "problem")


def test_the_same_folder_twice_is_no_harm(tree):
    assert not of(quick(PXR_PLUGINPATH_NAME=f"{tree}:{tree}/"), "warning")


def test_host_with_another_openusd(tree):
    """The unresolved plugin stands for a host's library: its names are of another version."""
    one(quick("--openusd", PLUGINS / "unresolved.so", PXR_PLUGINPATH_NAME=str(tree)), "problem",
        "was built for OpenUSD", "unresolved.so has namespace pxrInternal_v0_99", "docs/hosts.md")
    one(quick("--openusd", PLUGINS / "absent.so", PXR_PLUGINPATH_NAME=str(tree)), "problem",
        "absent.so has no OpenUSD with Hydra")


def test_cache_that_cannot_be_written(tree, tmp_path):
    """Below a file there can be no folder, not even root's."""
    (tmp_path / "file").write_text("")
    findings = quick(PXR_PLUGINPATH_NAME=str(tree), HDSTF_CACHE_DIR=f"{tmp_path}/file/cache")
    one(findings, "warning", f"cache: {tmp_path}/file/cache cannot be written (", "HDSTF_CACHE_DIR")


def test_cache_that_is_off(tree, tmp_path):
    common = {"PXR_PLUGINPATH_NAME": str(tree), "HDSTF_CACHE_DIR": str(tmp_path)}
    one(quick(HDSTF_CACHE_MAX_MB="0", **common), "warning", "nothing is kept")
    one(quick(HDSTF_CACHE_MAX_MB="lots", **common), "warning", "HDSTF_CACHE_MAX_MB")


def test_variables(tree):
    findings = quick(PXR_PLUGINPATH_NAME=str(tree), HDSTF_SAMPLE="3", HDSTF_QUALITY="-1", HDSTF_TRANSPORT="dE2",
                     HDSTF_DEPTH_OF_FIELD="yes", PXR_PLUGINPATH="/opt/hdstf/plugin", HDSTF_SEED="7")
    warnings = "\n".join(of(findings, "warning"))
    assert len(of(findings, "warning")) == 5
    for part in ("HDSTF_SAMPLE is no variable of hdStf (did you mean HDSTF_SAMPLES",
                 "HDSTF_QUALITY=-1 is no value of stf:quality", "HDSTF_TRANSPORT=dE2 is no value of stf:transport",
                 "`dE1`, `classic`", "HDSTF_DEPTH_OF_FIELD=yes is no value", "PXR_PLUGINPATH is set"):
        assert part in warnings, warnings
    assert "environment: HDSTF_SEED=7 -> " in of(findings, "ok")


def test_denoiser_that_is_named_and_not_there(tree, tmp_path):
    one(quick(PXR_PLUGINPATH_NAME=str(tree), HDSTF_OIDN_LIBRARY=f"{tmp_path}/none.so"), "warning", "denoiser: ",
        "none.so")


def test_picture_that_fails(tree):
    """stfrecord takes the plugin of its own tree: all of that is copied."""
    programs = tree.parent / "bin"
    programs.mkdir()
    for name in ("stf", "stf-probe", "stfrecord"):
        shutil.copy(BUILD / "bin" / name, programs)
    replace_library(tree, "aborting.so")
    problems = of(doctor(stf=programs / "stf", PXR_PLUGINPATH_NAME=str(tree)), "problem")
    assert len(problems) == 2 and "render: 8 x 8 pixels: stfrecord ended by a signal (Aborted)" in problems[1], problems
    (programs / "stfrecord").unlink()
    one(doctor(stf=programs / "stf", PXR_PLUGINPATH_NAME=str(BUILD / "plugin")), "warning", "no stfrecord beside stf")
