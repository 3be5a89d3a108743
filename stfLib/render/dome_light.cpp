// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/dome_light.h"

#include "stfLib/base/hemisphere.h"

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;
constexpr double kSmoothContrast = 4; // brightest over mean
constexpr float kImagePart = 0.5f;    // of directions that go by a texture's brightness

// USD: a dome's texture has its north pole on +y, and longitude grows so that the middle of the image is at -z.
Vec2f latLong(const Vec3f& d) {
    const float u = 0.5f + std::atan2(d.x, -d.z) / (2 * kPi);
    const float v = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y) / kPi;
    return {u, v};
}

Vec3f fromLatLong(Vec2f uv) {
    const float phi = (uv.x - 0.5f) * 2 * kPi, theta = uv.y * kPi, s = std::sin(theta);
    return {s * std::sin(phi), std::cos(theta), -s * std::cos(phi)};
}

std::size_t searchCdf(const float* cdf, std::size_t n, float u, float& rest) {
    const std::size_t i = std::min<std::size_t>(n - 1, std::size_t(std::upper_bound(cdf, cdf + n, u) - cdf));
    const float lo = i ? cdf[i - 1] : 0.0f;
    rest = cdf[i] > lo ? std::min((u - lo) / (cdf[i] - lo), 0.999999f) : 0.5f;
    return i;
}
} // namespace

void DomeLight::buildCdf() {
    const std::size_t w = std::size_t(image_.width), h = std::size_t(image_.height);
    columnCdf_.resize(w * h);
    rowCdf_.resize(h);
    double total = 0;
    for (std::size_t y = 0; y < h; ++y) {
        const double s = std::sin(double(kPi) * (double(y) + 0.5) / double(h));
        double row = 0;
        for (std::size_t x = 0; x < w; ++x) {
            row += double(luminance(image_.pixels[y * w + x]));
            columnCdf_[y * w + x] = float(row);
        }
        for (std::size_t x = 0; x < w; ++x) {
            columnCdf_[y * w + x] = row > 0 ? float(double(columnCdf_[y * w + x]) / row) : float(x + 1) / float(w);
        }
        total += row * s;
        rowCdf_[y] = float(total);
    }
    double brightest = 0, sines = 0;
    for (const Rgb& p : image_.pixels) {
        brightest = std::max(brightest, double(luminance(p)));
    }
    for (std::size_t y = 0; y < h; ++y) {
        sines += std::sin(double(kPi) * (double(y) + 0.5) / double(h)) * double(w);
    }
    smooth_ = brightest * sines <= kSmoothContrast * total;
    for (float& r : rowCdf_) {
        r = total > 0 ? float(double(r) / total) : 0.0f;
    }
    if (!(total > 0)) { // a black texture: nothing to prefer
        rowCdf_.clear();
    }
}

Rgb DomeLight::lookUp(const Vec3f& d) const {
    if (image_.empty()) {
        return tint_;
    }
    // Bilinear, periodic in longitude.
    const Vec2f uv = latLong(d);
    const float fx = uv.x * float(image_.width) - 0.5f, fy = uv.y * float(image_.height) - 0.5f;
    const int x0 = int(std::floor(fx)), y0 = int(std::floor(fy));
    const float ax = fx - float(x0), ay = fy - float(y0);
    const auto pixel = [&](int x, int y) {
        x = (x % image_.width + image_.width) % image_.width;
        return image_.at(x, std::clamp(y, 0, image_.height - 1));
    };
    return tint_ * ((pixel(x0, y0) * (1 - ax) + pixel(x0 + 1, y0) * ax) * (1 - ay) +
                    (pixel(x0, y0 + 1) * (1 - ax) + pixel(x0 + 1, y0 + 1) * ax) * ay);
}

float DomeLight::imageDensity(const Vec3f& d) const {
    if (rowCdf_.empty()) {
        return 0;
    }
    const Vec2f uv = latLong(d);
    const std::size_t w = std::size_t(image_.width), h = std::size_t(image_.height);
    const std::size_t x = std::min(w - 1, std::size_t(std::max(0.0f, uv.x) * float(w)));
    const std::size_t y = std::min(h - 1, std::size_t(std::max(0.0f, uv.y) * float(h)));
    const float row = rowCdf_[y] - (y ? rowCdf_[y - 1] : 0.0f);
    const float column = columnCdf_[y * w + x] - (x ? columnCdf_[y * w + x - 1] : 0.0f);
    const float s = std::max(1e-6f, std::sin(uv.y * kPi));
    return row * column * float(w * h) / (2 * kPi * kPi * s);
}

Vec3f DomeLight::sampleImage(Vec2f u) const {
    const std::size_t w = std::size_t(image_.width), h = std::size_t(image_.height);
    float fx = 0, fy = 0;
    const std::size_t y = searchCdf(rowCdf_.data(), h, u.y, fy);
    const std::size_t x = searchCdf(columnCdf_.data() + y * w, w, u.x, fx);
    return fromLatLong({(float(x) + fx) / float(w), (float(y) + fy) / float(h)});
}

DomeLight::DomeLight(const std::string& id, const Light& light, const MessageSink& messages)
    : tint_(light.emission), lightToWorld_(light.lightToWorld), worldToLight_(light.lightToWorld.inverse()) {
    if (light.textureFile.empty()) {
        return;
    }
    try {
        image_ = readLatLong(light.textureFile);
        buildCdf();
    } catch (const std::exception& e) {
        report(messages, Severity::Error, id + ": texture " + e.what() + "; the dome is uniform");
    }
}

Rgb DomeLight::radiance(const Vec3f& towards) const {
    return lookUp(normalize(Vec3f(worldToLight_.vector(Vec3d(towards)))));
}

float DomeLight::density(const Vec3f& normal, const Vec3f& towards) const {
    const float imagePart = rowCdf_.empty() ? 0.0f : kImagePart;
    float sum = (1 - imagePart) * mixedHemisphereDensity(dot(normal, towards));
    if (imagePart > 0) {
        sum += imagePart * imageDensity(normalize(Vec3f(worldToLight_.vector(Vec3d(towards)))));
    }
    return sum;
}

Rgb DomeLight::sample(const Vec3f& normal, Vec2f u, Vec3f& towards, float& chosen) const {
    // One sample of a mixture, weighted by the density of the whole mixture (balance heuristic). The uniform part
    // bounds the weight where the shell at some depth faces another way than the entry point.
    const float imagePart = rowCdf_.empty() ? 0.0f : kImagePart;
    if (u.x < imagePart) {
        towards = normalize(Vec3f(lightToWorld_.vector(Vec3d(sampleImage({u.x / imagePart, u.y})))));
    } else {
        Vec3f t, b;
        orthonormalBasis(normal, t, b);
        const Vec3f d = mixedHemisphere({(u.x - imagePart) / (1 - imagePart), u.y});
        towards = normalize(t * d.x + b * d.y + normal * d.z);
    }
    chosen = density(normal, towards);
    return chosen > 1e-9f ? radiance(towards) / chosen : Rgb(0.0f);
}

} // namespace stf
