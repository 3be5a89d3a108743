// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/light_set.h"

namespace stf {

namespace {
constexpr float kPi = 3.14159265358979f;

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

void LightSet::Prepared::buildCdf() {
    const std::size_t w = std::size_t(image.width), h = std::size_t(image.height);
    columnCdf.resize(w * h);
    rowCdf.resize(h);
    double total = 0;
    for (std::size_t y = 0; y < h; ++y) {
        const double s = std::sin(double(kPi) * (double(y) + 0.5) / double(h));
        double row = 0;
        for (std::size_t x = 0; x < w; ++x) {
            row += double(luminance(image.pixels[y * w + x]));
            columnCdf[y * w + x] = float(row);
        }
        for (std::size_t x = 0; x < w; ++x) {
            columnCdf[y * w + x] = row > 0 ? float(double(columnCdf[y * w + x]) / row) : float(x + 1) / float(w);
        }
        total += row * s;
        rowCdf[y] = float(total);
    }
    for (float& r : rowCdf) {
        r = total > 0 ? float(double(r) / total) : 0.0f;
    }
    if (!(total > 0)) { // a black texture: nothing to prefer
        rowCdf.clear();
    }
}

Rgb LightSet::Prepared::radiance(const Vec3f& d) const {
    if (image.empty()) {
        return tint;
    }
    // Bilinear, periodic in longitude.
    const Vec2f uv = latLong(d);
    const float fx = uv.x * float(image.width) - 0.5f, fy = uv.y * float(image.height) - 0.5f;
    const int x0 = int(std::floor(fx)), y0 = int(std::floor(fy));
    const float ax = fx - float(x0), ay = fy - float(y0);
    const auto pixel = [&](int x, int y) {
        x = (x % image.width + image.width) % image.width;
        return image.at(x, std::clamp(y, 0, image.height - 1));
    };
    return tint * ((pixel(x0, y0) * (1 - ax) + pixel(x0 + 1, y0) * ax) * (1 - ay) +
                   (pixel(x0, y0 + 1) * (1 - ax) + pixel(x0 + 1, y0 + 1) * ax) * ay);
}

float LightSet::Prepared::imageDensity(const Vec3f& d) const {
    if (rowCdf.empty()) {
        return 0;
    }
    const Vec2f uv = latLong(d);
    const std::size_t w = std::size_t(image.width), h = std::size_t(image.height);
    const std::size_t x = std::min(w - 1, std::size_t(std::max(0.0f, uv.x) * float(w)));
    const std::size_t y = std::min(h - 1, std::size_t(std::max(0.0f, uv.y) * float(h)));
    const float row = rowCdf[y] - (y ? rowCdf[y - 1] : 0.0f);
    const float column = columnCdf[y * w + x] - (x ? columnCdf[y * w + x - 1] : 0.0f);
    const float s = std::max(1e-6f, std::sin(uv.y * kPi));
    return row * column * float(w * h) / (2 * kPi * kPi * s);
}

Vec3f LightSet::Prepared::sampleImage(Vec2f u) const {
    const std::size_t w = std::size_t(image.width), h = std::size_t(image.height);
    float fx = 0, fy = 0;
    const std::size_t y = searchCdf(rowCdf.data(), h, u.y, fy);
    const std::size_t x = searchCdf(columnCdf.data() + y * w, w, u.x, fx);
    return fromLatLong({(float(x) + fx) / float(w), (float(y) + fy) / float(h)});
}

LightSet::LightSet(const std::map<std::string, Light>& lights, const MessageSink& messages) {
    for (const auto& [id, light] : lights) {
        if (!light.visible || !(maxComponent(light.emission) > 0) || !isFinite(light.emission)) {
            if (!isFinite(light.emission)) {
                report(messages, Severity::Error, id + ": the light's intensity is not finite, it is left out");
            }
            continue;
        }
        if (!light.lightToWorld.invertible()) {
            report(messages, Severity::Error, id + ": the light's transform is singular, it is left out");
            continue;
        }
        Prepared p;
        p.type = light.type;
        p.lightToWorld = light.lightToWorld;
        p.worldToLight = light.lightToWorld.inverse();
        if (light.type == Light::Type::Distant) {
            p.axis = Vec3f(normalize(light.lightToWorld.vector({0, 0, 1})));
            const double half = std::clamp(double(light.angle), 0.0, 180.0) * double(kPi) / 360.0;
            p.cosAngle = float(std::cos(half));
            p.irradiance = light.emission;
            if (!light.normalize && half > 0) {
                // `emission` is radiance: the disc's projected solid angle is pi sin^2.
                p.irradiance *= float(double(kPi) * std::sin(half) * std::sin(half));
            }
        } else {
            p.tint = light.emission;
            if (!light.textureFile.empty()) {
                try {
                    p.image = readLatLong(light.textureFile);
                    p.buildCdf();
                } catch (const std::exception& e) {
                    report(messages, Severity::Error, id + ": texture " + e.what() + "; the dome is uniform");
                }
            }
        }
        lights_.push_back(std::move(p));
    }
}

LightSample LightSet::sample(std::size_t index, const Vec3f& normal, Vec2f u) const {
    const Prepared& l = lights_[index];
    LightSample s;
    if (l.type == Light::Type::Distant) {
        // Uniform in projected solid angle: constant radiance, so the weight is the irradiance itself.
        s.towards = l.axis;
        s.irradiance = l.irradiance;
        if (l.cosAngle < 1) {
            Vec3f t, b;
            orthonormalBasis(l.axis, t, b);
            const float sin2 = u.x * (1 - l.cosAngle * l.cosAngle), r = std::sqrt(sin2), phi = 2 * kPi * u.y;
            s.towards = normalize(t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + l.axis * std::sqrt(1 - sin2));
        }
        return s;
    }
    // One sample of a mixture, weighted by the density of the whole mixture (balance heuristic). The uniform part
    // bounds the weight where the shell at some depth faces another way than the entry point.
    const bool textured = !l.rowCdf.empty();
    const float imagePart = textured ? 0.5f : 0.0f, cosinePart = 0.75f * (1 - imagePart),
                uniformPart = 1 - imagePart - cosinePart;
    if (u.x < imagePart) {
        u.x /= imagePart;
        s.towards = normalize(Vec3f(l.lightToWorld.vector(Vec3d(l.sampleImage(u)))));
    } else {
        Vec3f t, b;
        orthonormalBasis(normal, t, b);
        float cosTheta = 0;
        if (u.x < imagePart + cosinePart) {
            cosTheta = std::sqrt(std::max(0.0f, 1 - (u.x - imagePart) / cosinePart));
        } else {
            cosTheta = std::max(0.0f, 1 - (u.x - imagePart - cosinePart) / uniformPart);
        }
        const float r = std::sqrt(std::max(0.0f, 1 - cosTheta * cosTheta)), phi = 2 * kPi * u.y;
        s.towards = normalize(t * (r * std::cos(phi)) + b * (r * std::sin(phi)) + normal * cosTheta);
    }
    const Vec3f inLight = normalize(Vec3f(l.worldToLight.vector(Vec3d(s.towards))));
    const float cosine = dot(normal, s.towards);
    float density = cosine > 0 ? cosinePart * cosine / kPi + uniformPart / (2 * kPi) : 0.0f;
    if (textured) {
        density += imagePart * l.imageDensity(inLight);
    }
    s.irradiance = density > 1e-9f ? l.radiance(inLight) / density : Rgb(0.0f);
    return s;
}

Rgb LightSet::background(const Vec3f& direction) const {
    Rgb sum(0.0f);
    for (const Prepared& l : lights_) {
        if (l.type == Light::Type::Dome) {
            sum += l.radiance(normalize(Vec3f(l.worldToLight.vector(Vec3d(direction)))));
        }
    }
    return sum;
}

bool LightSet::hasDome() const {
    for (const Prepared& l : lights_) {
        if (l.type == Light::Type::Dome) {
            return true;
        }
    }
    return false;
}

} // namespace stf
