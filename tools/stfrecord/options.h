// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stfrecord {

/// Exit codes (docs/settings.md).
enum ExitCode { Rendered = 0, RenderedWithErrors = 1, NothingRendered = 2, BadUsage = 64, Interrupted = 130 };

/// What the command line asks for.
struct Options {
    std::string scene;
    std::string output; ///< empty: where the render products say
    /// Path of a RenderSettings prim; empty: the stage's own, unless the image is described here.
    std::string renderSettings;
    bool describesImage = false; ///< camera, size, window or AOVs were given
    bool givesPurposes = false;
    std::string camera;
    int imageWidth = 960;
    std::vector<double> frames; ///< empty: the first time of the scene
    /// x and y from, x and y to, as shares of the frame from its lower left; may reach beyond 0..1.
    std::optional<std::array<float, 4>> crop;
    bool denoise = false;
    std::optional<int> samples;
    std::optional<int> seed;
    std::optional<int> threads;
    std::vector<std::string> aovs = {"color"};
    std::vector<std::pair<std::string, std::string>> settings;
    std::string renderer = "Stf";
    std::vector<std::string> purposes = {"default", "render"};
    int refineLevel = 2;
    bool sceneIndices = false;
    std::string png;
    std::string stats;
    bool plan = false;
    bool quiet = false;
};

/// Frames as usdrecord takes them: `A`, `A:B`, `A:BxS`, and such separated by commas. Empty with a sentence in `error`
/// where they cannot be read, lead nowhere, or are more than a million.
std::vector<double> parseFrames(const std::string& text, std::string& error);

/// The file of a frame: a run of `#` becomes the number, padded with zeros to its length; without one, and with several
/// frames, the number goes before the extension (four digits).
std::string framePath(const std::string& pattern, double frame, bool several);

/// The file of one of several render products: its name goes before the extension.
std::string productPath(const std::string& pattern, const std::string& product, bool several);

/// Fills `options`. Returns nothing to go on, or the exit code after help or a message.
std::optional<int> parseOptions(int argc, char** argv, Options& options);

} // namespace stfrecord
