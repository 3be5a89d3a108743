// SPDX-License-Identifier: Apache-2.0
#include "tools/doctor/render_check.h"

#include "stfLib/base/error.h"
#include "stfLib/base/temporary_folder.h"
#include "stfLib/volume/make_samples.h"
#include "stfLib/volume/volume_io.h"
#include "tools/stf/run_program.h"

#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace stf::doctor {

namespace {

constexpr double kMostSeconds = 300;

/// A slab of one tile under a sun, seen from above. Millimetres. Lights as old and new versions of OpenUSD spell them.
const char* const kScene = R"(#usda 1.0
(
    metersPerUnit = 0.001
    upAxis = "Y"
)

def Mesh "Slab" (
    prepend apiSchemas = ["StfShellAPI"]
)
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-8, 0, 8), (8, 0, 8), (8, 0, -8), (-8, 0, -8)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
        interpolation = "vertex"
    )
    uniform token subdivisionScheme = "none"
    asset primvars:stf:baseVolume = @./volume.vdb@ (
        interpolation = "constant"
    )
    token primvars:stf:mapping = "uv" (
        interpolation = "constant"
    )
}

def DistantLight "Sun"
{
    float intensity = 3
    float inputs:intensity = 3
    float angle = 1
    float inputs:angle = 1
    float3 xformOp:rotateXYZ = (-60, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}

def Camera "Camera"
{
    float2 clippingRange = (1, 1000)
    float focalLength = 50
    float horizontalAperture = 20
    float verticalAperture = 20
    float3 xformOp:rotateXYZ = (-90, 0, 0)
    double3 xformOp:translate = (0, 40, 0)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}
)";

/// The last line that is not empty.
std::string lastLine(const std::string& path) {
    std::ifstream file(path);
    std::string last;
    for (std::string line; std::getline(file, line);) {
        if (!line.empty()) {
            last = line;
        }
    }
    return last;
}

} // namespace

Findings checkRender(const std::string& stfrecord) {
    std::error_code error;
    if (!std::filesystem::exists(stfrecord, error)) {
        return {warning("render", "there is no stfrecord beside stf: nothing was rendered",
                        "build with OpenUSD (HDSTF_BUILD_HYDRA)")};
    }
    try {
        const TemporaryFolder folder;
        SampleOptions sample;
        sample.size = {8, 8, 8};
        writeBaseVolume(makeSample("uniform", sample), folder.file("volume.vdb"));
        std::ofstream(folder.file("scene.usda")) << kScene;
        ProgramRun how;
        how.standardOutput = folder.file("output");
        how.standardError = folder.file("errors");
        how.mostSeconds = kMostSeconds;
        const auto start = std::chrono::steady_clock::now();
        // `env` keeps the tables of this scene out of everybody's cache.
        const ProgramEnd end =
            runProgram({"env", "HDSTF_CACHE_DIR=" + folder.file("cache"), stfrecord, folder.file("scene.usda"),
                        folder.file("image.exr"), "--imageWidth", "8", "--samples", "4", "--set", "stf:quality=0.3",
                        "--set", "stf:errorTarget=0", "--set", "stf:integrator=stf", "--set", "stf:denoise=false"},
                       how);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        if (end.timedOut) {
            return {problem("render", "8 x 8 pixels were not there after five minutes", "see what stfrecord says")};
        }
        const std::string said = lastLine(how.standardError);
        if (end.signal != 0 || end.code != 0 || !std::filesystem::exists(folder.file("image.exr"), error)) {
            const std::string how_ended = end.signal != 0
                                              ? std::string("ended by a signal (") + ::strsignal(end.signal) + ")"
                                              : "ended with " + std::to_string(end.code);
            return {problem("render", "8 x 8 pixels: stfrecord " + how_ended + (said.empty() ? "" : ": " + said),
                            "mend what is said above first; then stfrecord says more")};
        }
        char text[64];
        std::snprintf(text, sizeof text, "a shell of 8 x 8 pixels took %.1f s", seconds.count());
        return {ok("render", text)};
    } catch (const Error& e) {
        return {problem("render", e.what(), "mend what is said above first")};
    }
}

} // namespace stf::doctor
