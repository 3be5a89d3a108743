// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/vec.h"

#include <cstdint>
#include <string>
#include <vector>

namespace stf {

/// Arbitrary output variables, named as in the image contract.
enum class Aov {
    Color,    ///< rgba, linear Rec.709, premultiplied alpha
    Denoised, ///< the same without its noise, where a denoiser was asked; else the same
    Alpha,
    Depth,       ///< normalised device depth mapped to 0 (near) .. 1 (far); 1 where nothing is hit
    CameraDepth, ///< distance along the view axis, scene units
    Normal,      ///< world space
    Neye,        ///< camera space
    Position,    ///< world space
    Albedo,
    PrimId,
    InstanceId,
    ElementId,
    SampleCount,
    Variance, ///< variance of the pixel's mean colour, rgb
    StfSingle,
    StfMultiple,
    StfCore,
    StfReflection,
    CryptoObject00, ///< two ranks of id and coverage each (cryptomatte.h): the two that cover most, and so on
    CryptoObject01,
    CryptoObject02
};
constexpr int kCoverageRanks = 6; ///< in the three layers

/// Token to Aov; false for a name that is not known.
bool aovFromName(const std::string& name, Aov& aov);
bool aovIsInteger(Aov aov);
/// A layer of a cryptomatte.
inline bool aovIsCrypto(Aov aov) {
    return aov == Aov::CryptoObject00 || aov == Aov::CryptoObject01 || aov == Aov::CryptoObject02;
}
int aovChannels(Aov aov);

/// What one camera sample adds to a pixel.
struct PixelSample {
    Rgb color{0.0f};
    float alpha = 0;
    Rgb single{0.0f}, multiple{0.0f}, core{0.0f};
    Rgb reflection{0.0f}; ///< seen in the shell's surface, of whatever kind it is

    /// Which objects the alpha is of.
    struct Cover {
        std::uint32_t object = 0; ///< cryptomatte's id
        float amount = 0;
    };
    static constexpr int kMostCovers = 4; ///< what is seen through still more objects counts as the last one's
    Cover covers[kMostCovers];
    int coverCount = 0;
    void cover(std::uint32_t object, float amount) {
        alpha += amount;
        for (int i = 0; i < coverCount; ++i) {
            if (covers[i].object == object || i == kMostCovers - 1) {
                covers[i].amount += amount;
                return;
            }
        }
        covers[coverCount++] = {object, amount};
    }
};

/// What is seen through the middle of a pixel, written by the first sample.
struct PixelHit {
    float depth = 1;
    float cameraDepth = 0;
    Vec3f normal{0.0f}, neye{0.0f}, position{0.0f};
    Rgb albedo{0.0f};
    std::int32_t primId = -1, instanceId = -1, elementId = -1;
};

/// Mean luminance of a pixel and its standard error; infinite below two samples.
struct LuminanceEstimate {
    double mean = 0, error = 0;
};

/// Which pixels of a frame are rendered: the frame is what the camera's projection covers, the window may be a part of
/// it or reach beyond it. Rows from the bottom up. A pixel of the frame gets the same light whatever the window is.
struct FrameWindow {
    int frameWidth = 0, frameHeight = 0;
    int x = 0, y = 0, width = 0, height = 0;
    bool operator==(const FrameWindow& w) const {
        return frameWidth == w.frameWidth && frameHeight == w.frameHeight && x == w.x && y == w.y && width == w.width &&
               height == w.height;
    }
};

/// Accumulates samples. One thread per pixel at a time; `read` not while samples are added.
class Film {
public:
    void resize(int width, int height);
    void clear();
    int width() const { return width_; }
    int height() const { return height_; }

    /// What the denoiser made of the colour, three floats a pixel, exposed; empty: nothing yet.
    void setDenoised(std::vector<float> color) { denoised_ = std::move(color); }
    bool hasDenoised() const { return !denoised_.empty(); }
    /// What colours are multiplied by when they are read, and variances by its square: 2^stops.
    void setExposure(double scale) { exposure_ = scale; }
    /// Whether to keep which objects cover a pixel; from the next `clear` on. Costs memory.
    void keepCoverage(bool keep) { keepCoverage_ = keep; }

    void add(int x, int y, const PixelSample& sample);
    /// Samples in a pixel so far: the number of the next one, so that an interrupted pass is taken up where it ended.
    std::uint32_t sampleCount(int x, int y) const;
    void setHit(int x, int y, const PixelHit& hit) { hits_[index(x, y)] = hit; }

    /// Rows from the bottom up (OpenGL order, as Hydra's buffers), `aovChannels` floats a pixel.
    std::vector<float> read(Aov aov) const;
    std::vector<std::int32_t> readIds(Aov aov) const;
    /// Of every pixel. Channels are taken as fully correlated: the safe side.
    std::vector<LuminanceEstimate> luminances() const;
    /// Mean over the image of the standard error of a pixel's luminance, relative to the mean luminance.
    double relativeError() const;

private:
    struct Accumulator { // 64 bytes: one line of the cache
        Vec3d color, colorSquared;
        double alpha = 0;
        std::uint32_t count = 0;
    };
    struct Parts { // of the colour, on shells
        Vec3d single, multiple, core, reflection;
    };
    /// Samples of a pixel are stratified among each other and err less than independent ones would. As many that follow
    /// each other are stratified, too: means of these are what the pixel's error is told from, a little too large
    /// still.
    static constexpr std::uint32_t kBlock = 4;
    struct Blocks {
        Vec3d sum, squared; ///< of the block that is being filled; of the means of those that are full
    };
    Vec3d varianceOf(std::size_t pixel) const; ///< of the mean colour
    LuminanceEstimate luminanceOf(std::size_t pixel) const;
    void addCoverage(std::size_t pixel, const PixelSample& sample);
    /// The objects of a pixel that cover most of it, by rank: shares of the pixel.
    std::vector<PixelSample::Cover> rankedCoverage(std::size_t pixel) const;
    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_) + std::size_t(x); }

    int width_ = 0, height_ = 0;
    double exposure_ = 1;
    std::vector<Accumulator> pixels_;
    std::vector<Blocks> blocks_;
    std::vector<Parts> parts_;
    std::vector<PixelHit> hits_;
    std::vector<float> denoised_;
    bool keepCoverage_ = false;
    std::vector<std::vector<PixelSample::Cover>> coverage_; ///< per pixel, sums over its samples; empty: not kept
};

} // namespace stf
