// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/film.h"

#include "stfLib/render/cryptomatte.h"

#include <algorithm>
#include <limits>

namespace stf {

namespace {

constexpr std::size_t kMostObjects = 64; // that a pixel keeps apart

struct AovInfo {
    const char* name;
    Aov aov;
    int channels;
};
constexpr AovInfo kAovs[] = {
    {"color", Aov::Color, 4},
    {"denoised", Aov::Denoised, 4},
    {"alpha", Aov::Alpha, 1},
    {"depth", Aov::Depth, 1},
    {"cameraDepth", Aov::CameraDepth, 1},
    {"normal", Aov::Normal, 3},
    {"Neye", Aov::Neye, 3},
    {"position", Aov::Position, 3},
    {"albedo", Aov::Albedo, 3},
    {"primId", Aov::PrimId, 1},
    {"instanceId", Aov::InstanceId, 1},
    {"elementId", Aov::ElementId, 1},
    {"sampleCount", Aov::SampleCount, 1},
    {"variance", Aov::Variance, 3},
    {"stf:single", Aov::StfSingle, 3},
    {"stf:multiple", Aov::StfMultiple, 3},
    {"stf:core", Aov::StfCore, 3},
    {"stf:reflection", Aov::StfReflection, 3},
    {"cryptoObject00", Aov::CryptoObject00, 4},
    {"cryptoObject01", Aov::CryptoObject01, 4},
    {"cryptoObject02", Aov::CryptoObject02, 4},
};

const AovInfo& info(Aov aov) {
    for (const AovInfo& i : kAovs) {
        if (i.aov == aov) {
            return i;
        }
    }
    return kAovs[0];
}

} // namespace

bool aovFromName(const std::string& name, Aov& aov) {
    for (const AovInfo& i : kAovs) {
        if (name == i.name) {
            aov = i.aov;
            return true;
        }
    }
    return false;
}

bool aovIsInteger(Aov aov) {
    return aov == Aov::PrimId || aov == Aov::InstanceId || aov == Aov::ElementId;
}

int aovChannels(Aov aov) {
    return info(aov).channels;
}

void Film::resize(int width, int height) {
    width_ = std::max(0, width);
    height_ = std::max(0, height);
    clear();
}

void Film::clear() {
    const std::size_t n = std::size_t(width_) * std::size_t(height_);
    pixels_.assign(n, Accumulator());
    blocks_.assign(n, Blocks());
    parts_.assign(n, Parts());
    hits_.assign(n, PixelHit());
    denoised_.clear();
    coverage_.clear();
    coverage_.resize(keepCoverage_ ? n : 0);
}

std::uint32_t Film::sampleCount(int x, int y) const {
    return pixels_[index(x, y)].count;
}

void Film::add(int x, int y, const PixelSample& s) {
    const std::size_t i = index(x, y);
    Accumulator& a = pixels_[i];
    const Vec3d c(s.color);
    a.color += c;
    a.colorSquared += c * c;
    a.alpha += double(s.alpha);
    ++a.count;
    Blocks& b = blocks_[i];
    b.sum += c;
    if (a.count % kBlock == 0) {
        const Vec3d mean = b.sum * (1.0 / kBlock);
        b.squared += mean * mean;
        b.sum = Vec3d(0.0);
    }
    if (!coverage_.empty()) {
        addCoverage(i, s);
    }
    const auto none = [](const Rgb& v) { return v.x == 0 && v.y == 0 && v.z == 0; };
    if (none(s.single) && none(s.multiple) && none(s.core) && none(s.reflection)) {
        return; // no shell: most of many pictures
    }
    Parts& p = parts_[i];
    p.single += Vec3d(s.single);
    p.multiple += Vec3d(s.multiple);
    p.core += Vec3d(s.core);
    p.reflection += Vec3d(s.reflection);
}

void Film::addCoverage(std::size_t i, const PixelSample& s) {
    std::vector<PixelSample::Cover>& sums = coverage_[i];
    for (int k = 0; k < s.coverCount; ++k) {
        const PixelSample::Cover& cover = s.covers[k];
        const auto known = std::find_if(sums.begin(), sums.end(),
                                        [&](const PixelSample::Cover& c) { return c.object == cover.object; });
        if (known != sums.end()) {
            known->amount += cover.amount;
        } else if (sums.size() < kMostObjects) {
            sums.push_back(cover);
        }
    }
}

std::vector<PixelSample::Cover> Film::rankedCoverage(std::size_t i) const {
    std::vector<PixelSample::Cover> ranked = coverage_[i];
    std::sort(ranked.begin(), ranked.end(), [](const PixelSample::Cover& a, const PixelSample::Cover& b) {
        return a.amount != b.amount ? a.amount > b.amount : a.object < b.object;
    });
    for (PixelSample::Cover& c : ranked) {
        c.amount /= float(std::max(1u, pixels_[i].count));
    }
    ranked.resize(kCoverageRanks);
    return ranked;
}

std::vector<float> Film::read(Aov aov) const {
    const std::size_t channels = std::size_t(aovChannels(aov));
    std::vector<float> out(pixels_.size() * channels);
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const Accumulator& a = pixels_[i];
        const PixelHit& h = hits_[i];
        const double inv = a.count ? 1.0 / a.count : 0.0, exposed = inv * exposure_;
        float* const p = out.data() + i * channels;
        const auto put = [&](const Vec3f& v) { p[0] = v.x, p[1] = v.y, p[2] = v.z; };
        switch (aov) {
        case Aov::Color:
            put(Rgb(a.color * exposed));
            p[3] = float(a.alpha * inv);
            break;
        case Aov::Denoised:
            put(denoised_.empty() ? Rgb(a.color * exposed)
                                  : Rgb(denoised_[3 * i], denoised_[3 * i + 1], denoised_[3 * i + 2]));
            p[3] = float(a.alpha * inv);
            break;
        case Aov::Alpha:
            p[0] = float(a.alpha * inv);
            break;
        case Aov::Depth:
            p[0] = h.depth;
            break;
        case Aov::CameraDepth:
            p[0] = h.cameraDepth;
            break;
        case Aov::Normal:
            put(h.normal);
            break;
        case Aov::Neye:
            put(h.neye);
            break;
        case Aov::Position:
            put(h.position);
            break;
        case Aov::Albedo:
            put(h.albedo);
            break;
        case Aov::SampleCount:
            p[0] = float(a.count);
            break;
        case Aov::Variance:
            put(Vec3f(varianceOf(i) * (exposure_ * exposure_)));
            break;
        case Aov::StfSingle:
            put(Rgb(parts_[i].single * exposed));
            break;
        case Aov::StfMultiple:
            put(Rgb(parts_[i].multiple * exposed));
            break;
        case Aov::StfCore:
            put(Rgb(parts_[i].core * exposed));
            break;
        case Aov::StfReflection:
            put(Rgb(parts_[i].reflection * exposed));
            break;
        case Aov::CryptoObject00:
        case Aov::CryptoObject01:
        case Aov::CryptoObject02:
            if (!coverage_.empty()) {
                const std::vector<PixelSample::Cover> ranked = rankedCoverage(i);
                for (std::size_t k = 0; k < 2; ++k) {
                    const PixelSample::Cover& r = ranked[2 * std::size_t(int(aov) - int(Aov::CryptoObject00)) + k];
                    p[2 * k] = cryptomatteFloat(r.object);
                    p[2 * k + 1] = r.amount;
                }
            }
            break;
        case Aov::PrimId:
        case Aov::InstanceId:
        case Aov::ElementId:
            break; // integers: readIds
        }
    }
    return out;
}

std::vector<std::int32_t> Film::readIds(Aov aov) const {
    std::vector<std::int32_t> out(hits_.size());
    for (std::size_t i = 0; i < hits_.size(); ++i) {
        out[i] = aov == Aov::PrimId       ? hits_[i].primId
                 : aov == Aov::InstanceId ? hits_[i].instanceId
                                          : hits_[i].elementId;
    }
    return out;
}

Vec3d Film::varianceOf(std::size_t i) const {
    const Accumulator& a = pixels_[i];
    const std::uint32_t full = a.count / kBlock;
    Vec3d v(0.0);
    if (full > 1) {
        // Samples beyond the last full block are left aside, but for their share in the mean's error.
        const Vec3d mean = (a.color - blocks_[i].sum) * (1.0 / (full * kBlock));
        v = (blocks_[i].squared * (1.0 / full) - mean * mean) * (double(full * kBlock) / a.count / (full - 1));
    } else if (a.count > 1) {
        const Vec3d mean = a.color * (1.0 / a.count);
        v = (a.colorSquared * (1.0 / a.count) - mean * mean) * (1.0 / (a.count - 1));
    }
    return {std::max(0.0, v.x), std::max(0.0, v.y), std::max(0.0, v.z)};
}

LuminanceEstimate Film::luminanceOf(std::size_t i) const {
    const Accumulator& a = pixels_[i];
    if (a.count < 2) {
        return {0, std::numeric_limits<double>::infinity()};
    }
    const Vec3d v = varianceOf(i);
    const Rgb deviation(float(std::sqrt(v.x)), float(std::sqrt(v.y)), float(std::sqrt(v.z)));
    return {double(luminance(Rgb(a.color * (1.0 / a.count)))), double(luminance(deviation))};
}

std::vector<LuminanceEstimate> Film::luminances() const {
    std::vector<LuminanceEstimate> out;
    out.reserve(pixels_.size());
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        out.push_back(luminanceOf(i));
    }
    return out;
}

double Film::relativeError() const {
    double mean = 0, error = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const LuminanceEstimate e = luminanceOf(i);
        if (std::isfinite(e.error)) {
            error += e.error;
            mean += e.mean;
        }
    }
    return mean > 0 ? error / mean : 0;
}

} // namespace stf
