// SPDX-License-Identifier: Apache-2.0
#include "stfLib/render/ies_profile.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

namespace stf {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kMostAngles = 2000;

class Numbers {
public:
    explicit Numbers(std::string text) : in_(std::move(text)) {}
    double next(const char* what) {
        double value = 0;
        if (!(in_ >> value) || !std::isfinite(value)) {
            throw Error(std::string("the number for ") + what + " is missing or not finite");
        }
        return value;
    }
    int count(const char* what) {
        const double value = next(what);
        if (!(value >= 1 && value <= kMostAngles) || value != std::floor(value)) {
            throw Error(std::string("the number of ") + what + " is not between 1 and " + std::to_string(kMostAngles));
        }
        return int(value);
    }
    std::vector<float> angles(int n, const char* what) {
        std::vector<float> out;
        for (int i = 0; i < n; ++i) {
            out.push_back(float(next(what)));
            if (i && !(out[std::size_t(i)] > out[std::size_t(i) - 1])) {
                throw Error(std::string(what) + " do not ascend");
            }
        }
        return out;
    }

private:
    std::istringstream in_;
};

/// Index of the interval of `angles` that holds x, and the share of its end.
std::size_t interval(const std::vector<float>& angles, float x, float& share) {
    if (angles.size() < 2) {
        share = 0;
        return 0;
    }
    const std::size_t i = std::size_t(std::clamp<std::ptrdiff_t>(
        std::upper_bound(angles.begin(), angles.end(), x) - angles.begin() - 1, 0, std::ptrdiff_t(angles.size()) - 2));
    share = std::clamp((x - angles[i]) / (angles[i + 1] - angles[i]), 0.0f, 1.0f);
    return i;
}

} // namespace

IesProfile IesProfile::parse(const std::string& text) {
    const std::size_t tilt = text.find("TILT=");
    if (tilt == std::string::npos) {
        throw Error("it has no TILT line: not a photometric profile (LM-63)");
    }
    const std::size_t end = std::min(text.find('\n', tilt), text.size());
    if (text.compare(tilt, 9, "TILT=NONE") != 0) {
        throw Error("lamps that shine by their tilt are not supported (TILT is not NONE)");
    }
    std::string rest = text.substr(end);
    std::replace(rest.begin(), rest.end(), ',', ' ');
    Numbers in(rest);
    in.next("lamps");
    in.next("lumens per lamp");
    const double multiplier = in.next("the multiplier");
    const int vertical = in.count("vertical angles"), horizontal = in.count("horizontal angles");
    if (in.next("the photometric type") != 1) {
        throw Error("only photometry of type C is supported");
    }
    for (const char* what : {"units", "width", "length", "height"}) {
        in.next(what);
    }
    const double ballast = in.next("the ballast factor");
    in.next("the field for future use");
    in.next("watts");
    IesProfile p;
    p.vertical_ = in.angles(vertical, "vertical angles");
    p.horizontal_ = in.angles(horizontal, "horizontal angles");
    const float last = p.horizontal_.back();
    if (p.horizontal_.front() != 0 || (last != 0 && last != 90 && last != 180 && last != 360)) {
        throw Error("horizontal angles do not go from 0 to 0, 90, 180 or 360");
    }
    for (int i = 0; i < vertical * horizontal; ++i) {
        const double value = in.next("candela") * multiplier * ballast;
        if (value < 0) {
            throw Error("an intensity is negative");
        }
        p.candela_.push_back(float(value));
    }
    // The integral by midpoints: intensity has kinks at the angles of the file only.
    constexpr int nv = 720, nh = 360;
    for (int v = 0; v < nv; ++v) {
        const double theta = kPi * (v + 0.5) / nv;
        for (int h = 0; h < nh; ++h) {
            p.power_ += double(p.intensity(float(theta), float(2 * kPi * (h + 0.5) / nh))) * std::sin(theta) *
                        (kPi / nv) * (2 * kPi / nh);
        }
    }
    return p;
}

IesProfile IesProfile::read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw Error("'" + path + "' cannot be read");
    }
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    try {
        return parse(text);
    } catch (const Error& e) {
        throw Error("'" + path + "': " + e.what());
    }
}

float IesProfile::intensity(float vertical, float horizontal) const {
    const float v = float(double(vertical) * 180 / kPi);
    const float slack = 1e-3f;
    if (!(v >= vertical_.front() - slack && v <= vertical_.back() + slack)) {
        return 0;
    }
    float h = float(std::fmod(double(horizontal) * 180 / kPi, 360.0));
    h = h < 0 ? h + 360 : h;
    const float last = horizontal_.back();
    if (last == 180 || last == 90) { // mirrored about the plane of 0 and 180 degrees
        h = h > 180 ? 360 - h : h;
    }
    if (last == 90) {
        h = h > 90 ? 180 - h : h;
    }
    float a = 0, b = 0;
    const std::size_t i = interval(vertical_, v, a), j = interval(horizontal_, h, b), n = vertical_.size();
    const std::size_t i1 = std::min(i + 1, n - 1), j1 = std::min(j + 1, horizontal_.size() - 1);
    const float near = candela_[j * n + i] * (1 - a) + candela_[j * n + i1] * a;
    const float far = candela_[j1 * n + i] * (1 - a) + candela_[j1 * n + i1] * a;
    return near * (1 - b) + far * b;
}

} // namespace stf
