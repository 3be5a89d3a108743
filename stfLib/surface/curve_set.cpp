// SPDX-License-Identifier: Apache-2.0
#include "stfLib/surface/curve_set.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stf {

namespace {

using Basis = CurveSet::Basis;
using Wrap = CurveSet::Wrap;
using Interpolation = CurveSet::Interpolation;

constexpr float largestCoordinate = 1e18f; // as of meshes: beyond it a square is no float any more

bool usable(float v) {
    return std::abs(v) < largestCoordinate;
}
bool usable(const Vec3f& v) {
    return usable(v.x) && usable(v.y) && usable(v.z);
}

/// Spans of a curve of so many vertices; 0: it has none, or the number does not fit.
int spansOf(Basis basis, Wrap wrap, int vertices) {
    const bool periodic = wrap == Wrap::Periodic;
    switch (basis) {
    case Basis::Linear:
        return vertices < 2 ? 0 : wrap == Wrap::Segmented ? vertices / 2 : periodic ? vertices : vertices - 1;
    case Basis::Bezier:
        if (periodic) {
            return vertices >= 3 && vertices % 3 == 0 ? vertices / 3 : 0;
        }
        return vertices >= 4 && vertices % 3 == 1 ? (vertices - 1) / 3 : 0;
    default:
        if (periodic) {
            return vertices >= 3 ? vertices : 0;
        }
        return wrap == Wrap::Pinned ? std::max(0, vertices - 1) : std::max(0, vertices - 3);
    }
}

/// Values of varying primvars that a curve has.
int varyingsOf(Basis basis, Wrap wrap, int vertices) {
    if (basis == Basis::Linear) {
        return std::max(0, vertices);
    }
    const int spans = spansOf(basis, wrap, vertices);
    return spans == 0 || wrap == Wrap::Periodic ? spans : spans + 1;
}

/// A piece of the input that is drawn as one tube or ribbon.
struct Strand {
    int curve = 0;
    std::size_t vertex = 0;  ///< its first one, among those of all curves
    std::size_t varying = 0; ///< its first value of varying primvars
    int vertices = 0;
    int spans = 0;
};

struct Detail {
    int sides, pieces;
};
// From the coarsest on; a host's levels begin with the second.
constexpr std::array<Detail, 5> details = {{{3, 1}, {4, 2}, {6, 4}, {8, 6}, {12, 8}}};

/// A place along a strand.
struct Station {
    Vec3f at;
    float radius = 0;
    Rgb color;
    Vec3f normal; ///< of ribbons
};

class Tessellation {
public:
    Tessellation(const CurveSet& curves, CurveRepairs& repairs)
        : curves_(curves), repairs_(repairs), periodic_(curves.wrap == Wrap::Periodic) {
        repairs_.droppedWidths = !take(curves.widths, widths_);
        repairs_.droppedColors = !take(curves.colors, colors_);
        repairs_.droppedNormals = !take(curves.normals, normals_);
        for (float& width : widths_.values) {
            if (width < 0) {
                width = 0;
                ++repairs_.nonFiniteValues;
            }
        }
        ribbons_ = !normals_.values.empty();
    }

    ControlMesh run(int level, std::size_t maxTriangles) {
        mesh_.scheme = ControlMesh::Scheme::None;
        mesh_.normalInterpolation = mesh_.colorInterpolation = ControlMesh::Interpolation::Vertex;
        std::vector<Strand> strands = findStrands();
        std::size_t detail = std::size_t(std::clamp(level, 0, 3)) + 1;
        while (detail > 0 && trianglesOf(strands, details[detail]) > maxTriangles) {
            --detail;
            repairs_.coarser = true;
        }
        detail_ = details[detail];
        thin(strands, maxTriangles);
        for (const Strand& strand : strands) {
            add(strand);
        }
        if (colors_.values.empty()) {
            mesh_.colors.clear();
        }
        return std::move(mesh_);
    }

private:
    /// A primvar whose number of values fits, with zero for those that are not finite; false if it does not.
    template<class T>
    bool take(const CurveSet::Primvar<T>& from, CurveSet::Primvar<T>& to) {
        if (from.values.empty()) {
            return true;
        }
        // One value is for all, whatever it is said to be: who forgets the interpolation of widths says "vertex".
        const bool constant = from.values.size() == 1 || from.interpolation == Interpolation::Constant;
        if (!constant && from.values.size() != curves_.valueCount(from.interpolation)) {
            return false;
        }
        to = from;
        if (constant) {
            to.interpolation = Interpolation::Constant;
        }
        for (T& value : to.values) {
            if (!usable(value)) {
                value = T();
                ++repairs_.nonFiniteValues;
            }
        }
        return true;
    }

    std::vector<Strand> findStrands() {
        const std::size_t available = curves_.indices.empty() ? curves_.points.size() : curves_.indices.size();
        std::vector<char> hidden(curves_.vertexCounts.size(), 0);
        for (int c : curves_.hidden) {
            if (c >= 0 && std::size_t(c) < hidden.size()) {
                hidden[std::size_t(c)] = 1;
            }
        }
        std::vector<Strand> strands;
        std::size_t vertex = 0, varying = 0;
        for (std::size_t c = 0; c < curves_.vertexCounts.size(); ++c) {
            const int count = curves_.vertexCounts[c];
            if (count < 0 || std::size_t(count) > available - vertex) {
                // What follows cannot be told apart any more.
                repairs_.wrongCounts += int(curves_.vertexCounts.size() - c);
                break;
            }
            const Strand whole = {int(c), vertex, varying, count, spansOf(curves_.basis, curves_.wrap, count)};
            vertex += std::size_t(count);
            varying += std::size_t(varyingsOf(curves_.basis, curves_.wrap, count));
            if (hidden[c]) {
                continue;
            }
            if (whole.spans == 0) {
                ++repairs_.wrongCounts;
            } else if (!pointsUsable(whole)) {
                ++repairs_.badPoints;
            } else if (curves_.wrap == Wrap::Segmented) {
                for (int s = 0; s < whole.spans; ++s) {
                    strands.push_back(
                        {whole.curve, whole.vertex + std::size_t(2 * s), whole.varying + std::size_t(2 * s), 2, 1});
                }
            } else {
                strands.push_back(whole);
            }
        }
        return strands;
    }

    std::size_t pointOf(std::size_t vertex) const {
        return curves_.indices.empty() ? vertex : std::size_t(curves_.indices[vertex]);
    }

    bool pointsUsable(const Strand& strand) const {
        for (std::size_t v = strand.vertex; v < strand.vertex + std::size_t(strand.vertices); ++v) {
            if (!curves_.indices.empty() && curves_.indices[v] < 0) {
                return false;
            }
            if (pointOf(v) >= curves_.points.size() || !usable(curves_.points[pointOf(v)])) {
                return false;
            }
        }
        return true;
    }

    int piecesOf(const Detail& detail) const { return curves_.basis == Basis::Linear ? 1 : detail.pieces; }

    std::size_t trianglesOf(const Strand& strand, const Detail& detail) const {
        const std::size_t rings = std::size_t(strand.spans) * std::size_t(piecesOf(detail));
        return ribbons_ ? 2 * rings : 2 * rings * std::size_t(detail.sides) + 2 * std::size_t(detail.sides - 2);
    }
    std::size_t trianglesOf(const std::vector<Strand>& strands, const Detail& detail) const {
        std::size_t sum = 0;
        for (const Strand& strand : strands) {
            sum += trianglesOf(strand, detail);
        }
        return sum;
    }

    void thin(std::vector<Strand>& strands, std::size_t maxTriangles) {
        std::vector<Strand> kept = strands;
        while (trianglesOf(kept, detail_) > maxTriangles && kept.size() > 1) {
            const std::size_t needed = trianglesOf(kept, detail_) / std::max<std::size_t>(maxTriangles, 1);
            repairs_.everyNth += std::max(1, repairs_.everyNth * int(std::min<std::size_t>(needed, 1u << 20)));
            kept.clear();
            for (std::size_t i = 0; i < strands.size(); i += std::size_t(repairs_.everyNth)) {
                kept.push_back(strands[i]);
            }
        }
        if (trianglesOf(kept, detail_) > maxTriangles) {
            kept.clear(); // a single curve that is too long
        }
        strands.swap(kept);
    }

    /// The value at u, 0 to 1, of a span.
    template<class T>
    T at(const CurveSet::Primvar<T>& primvar, const Strand& strand, int span, float u) const {
        switch (primvar.interpolation) {
        case Interpolation::Constant:
            return primvar.values[0];
        case Interpolation::Uniform:
            return primvar.values[std::size_t(strand.curve)];
        case Interpolation::Varying: {
            if (curves_.basis == Basis::Linear) {
                break; // the same as by vertex
            }
            const int next = periodic_ ? (span + 1) % strand.spans : span + 1;
            return primvar.values[strand.varying + std::size_t(span)] * (1 - u) +
                   primvar.values[strand.varying + std::size_t(next)] * u;
        }
        case Interpolation::Vertex:
            break;
        }
        return alongBasis(primvar.values, strand, span, u);
    }

    template<class T>
    T vertexValue(const std::vector<T>& values, const Strand& strand, int k) const {
        if (periodic_) {
            k %= strand.vertices;
        } else if (k < 0) {
            return vertexValue(values, strand, 0) * 2.0f - vertexValue(values, strand, 1);
        } else if (k >= strand.vertices) {
            return vertexValue(values, strand, strand.vertices - 1) * 2.0f -
                   vertexValue(values, strand, strand.vertices - 2);
        }
        return values[pointOf(strand.vertex + std::size_t(k))];
    }

    template<class T>
    T alongBasis(const std::vector<T>& values, const Strand& strand, int span, float u) const {
        const float v = 1 - u;
        if (curves_.basis == Basis::Linear) {
            return vertexValue(values, strand, span) * v + vertexValue(values, strand, span + 1) * u;
        }
        std::array<float, 4> w{};
        int first = span;
        if (curves_.basis == Basis::Bezier) {
            first = 3 * span;
            w = {v * v * v, 3 * u * v * v, 3 * u * u * v, u * u * u};
        } else if (curves_.basis == Basis::BSpline) {
            w = {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6,
                 u * u * u / 6};
        } else {
            w = {(-u * u * u + 2 * u * u - u) / 2, (3 * u * u * u - 5 * u * u + 2) / 2,
                 (-3 * u * u * u + 4 * u * u + u) / 2, (u * u * u - u * u) / 2};
        }
        if (curves_.wrap == Wrap::Pinned && curves_.basis != Basis::Bezier) {
            --first;
        }
        T sum = vertexValue(values, strand, first) * w[0];
        for (int k = 1; k < 4; ++k) {
            sum += vertexValue(values, strand, first + k) * w[std::size_t(k)];
        }
        return sum;
    }

    Station stationAt(const Strand& strand, int span, float u) const {
        Station station;
        station.at = alongBasis(curves_.points, strand, span, u);
        // A cubic through positive widths may go below zero.
        station.radius = widths_.values.empty() ? 0.5f : 0.5f * std::max(0.0f, at(widths_, strand, span, u));
        station.color = colors_.values.empty() ? Rgb() : at(colors_, strand, span, u);
        station.normal = ribbons_ ? at(normals_, strand, span, u) : Vec3f();
        return station;
    }

    /// Stations one after the other, without those that stand where the one before them does.
    std::vector<Station> stationsOf(const Strand& strand) const {
        const int pieces = piecesOf(detail_);
        std::vector<Station> stations;
        const auto append = [&](const Station& s) {
            if (stations.empty() || s.at != stations.back().at) {
                stations.push_back(s);
            }
        };
        for (int span = 0; span < strand.spans; ++span) {
            for (int p = 0; p < pieces; ++p) {
                append(stationAt(strand, span, float(p) / float(pieces)));
            }
        }
        if (!periodic_) {
            append(stationAt(strand, strand.spans - 1, 1));
        }
        while (periodic_ && stations.size() > 1 && stations.front().at == stations.back().at) {
            stations.pop_back();
        }
        return stations;
    }

    void add(const Strand& strand) {
        const std::vector<Station> stations = stationsOf(strand);
        const bool wide = std::any_of(stations.begin(), stations.end(), [](const Station& s) { return s.radius > 0; });
        const std::size_t least = periodic_ ? 3 : 2;
        if (stations.size() < least || !wide) {
            ++repairs_.withoutExtent;
            return;
        }
        directions(stations);
        if (ribbons_) {
            addRibbon(stations);
        } else {
            addTube(stations);
        }
    }

    /// Of the pieces before and after each station, and between both.
    void directions(const std::vector<Station>& stations) {
        const std::size_t n = stations.size();
        before_.resize(n);
        after_.resize(n);
        along_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t next = i + 1 < n ? i + 1 : periodic_ ? 0 : i;
            after_[i] = normalize(Vec3d(stations[next].at) - Vec3d(stations[i].at));
        }
        for (std::size_t i = 0; i < n; ++i) {
            before_[i] = i > 0 ? after_[i - 1] : periodic_ ? after_[n - 1] : after_[0];
        }
        if (!periodic_) {
            after_[n - 1] = before_[n - 1];
        }
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3d middle = before_[i] + after_[i];
            along_[i] = length(middle) > 1e-6 ? normalize(middle) : after_[i]; // where it turns back
        }
    }

    /// Vectors across the stations that turn about the curve as little as can be: the double reflection of Wang et al.
    /// 2008, "Computation of Rotation Minimizing Frames". Around a closed curve what is left over is spread evenly.
    std::vector<Vec3d> across(const std::vector<Station>& stations) const {
        const std::size_t n = stations.size();
        std::vector<Vec3d> result(n);
        Vec3d other;
        orthonormalBasis(along_[0], result[0], other);
        const auto transport = [&](std::size_t i, std::size_t j, const Vec3d& r) {
            const Vec3d v1 = Vec3d(stations[j].at) - Vec3d(stations[i].at);
            const double c1 = dot(v1, v1);
            const Vec3d reflected = r - v1 * (2 / c1 * dot(v1, r));
            const Vec3d tangent = along_[i] - v1 * (2 / c1 * dot(v1, along_[i]));
            const Vec3d v2 = along_[j] - tangent;
            const double c2 = dot(v2, v2);
            const Vec3d turned = c2 > 0 ? reflected - v2 * (2 / c2 * dot(v2, reflected)) : reflected;
            return normalize(turned - along_[j] * dot(along_[j], turned));
        };
        for (std::size_t i = 1; i < n; ++i) {
            result[i] = transport(i - 1, i, result[i - 1]);
        }
        if (periodic_) {
            const Vec3d back = transport(n - 1, 0, result[n - 1]);
            const double excess = std::atan2(dot(cross(back, result[0]), along_[0]), dot(back, result[0]));
            for (std::size_t i = 1; i < n; ++i) {
                const double angle = excess * double(i) / double(n);
                result[i] = result[i] * std::cos(angle) + cross(along_[i], result[i]) * std::sin(angle);
            }
        }
        return result;
    }

    void addPoint(const Vec3d& point, const Vec3d& normal, const Rgb& color) {
        mesh_.points.push_back(Vec3f(point));
        mesh_.normals.push_back(Vec3f(normal));
        mesh_.colors.push_back(color);
    }

    void addQuad(int a, int b, int c, int d) {
        mesh_.faceVertexCounts.push_back(4);
        mesh_.faceVertexIndices.insert(mesh_.faceVertexIndices.end(), {a, b, c, d});
    }

    void addTube(const std::vector<Station>& stations) {
        const std::size_t n = stations.size();
        const int sides = detail_.sides;
        const double half = M_PI / sides;
        const double outward = half / std::sin(half); // a polygon of the circle's perimeter
        const std::vector<Vec3d> first = across(stations);
        const int base = int(mesh_.points.size());
        for (std::size_t i = 0; i < n; ++i) {
            const Station& s = stations[i];
            const Vec3d second = cross(along_[i], first[i]);
            // A bend cuts the tube aslant: wider in the bend's plane, by no more than 2.
            const Vec3d bend = normalize(before_[i] - after_[i]);
            const double aslant = 1 / std::max(0.5, dot(before_[i], along_[i])) - 1;
            const double slope = slopeAt(stations, i);
            for (int k = 0; k < sides; ++k) {
                const double angle = 2 * half * k;
                const Vec3d radial = first[i] * std::cos(angle) + second * std::sin(angle);
                const Vec3d mitred = radial + bend * (aslant * dot(bend, radial));
                addPoint(Vec3d(s.at) + mitred * (outward * double(s.radius)), normalize(radial - along_[i] * slope),
                         s.color);
            }
        }
        for (std::size_t i = 0; i + (periodic_ ? 0 : 1) < n; ++i) {
            const int low = base + int(i) * sides, high = base + int((i + 1) % n) * sides;
            for (int k = 0; k < sides; ++k) {
                const int l = (k + 1) % sides;
                addQuad(low + k, low + l, high + l, high + k);
            }
        }
        if (!periodic_) {
            addCap(base, stations.front(), -along_.front(), true);
            addCap(base + int(n - 1) * sides, stations.back(), along_.back(), false);
        }
    }

    /// How much the radius grows along the curve.
    double slopeAt(const std::vector<Station>& stations, std::size_t i) const {
        const std::size_t n = stations.size();
        const std::size_t last = i > 0 ? i - 1 : periodic_ ? n - 1 : 0;
        const std::size_t next = i + 1 < n ? i + 1 : periodic_ ? 0 : i;
        const double way = length(Vec3d(stations[i].at) - Vec3d(stations[last].at)) +
                           length(Vec3d(stations[next].at) - Vec3d(stations[i].at));
        return way > 0 ? (double(stations[next].radius) - double(stations[last].radius)) / way : 0.0;
    }

    /// An end, with points of its own: it is flat.
    void addCap(int ring, const Station& s, const Vec3d& normal, bool start) {
        if (!(s.radius > 0)) {
            return;
        }
        const int sides = detail_.sides;
        const int base = int(mesh_.points.size());
        for (int k = 0; k < sides; ++k) {
            addPoint(Vec3d(mesh_.points[std::size_t(ring + k)]), normal, s.color);
        }
        mesh_.faceVertexCounts.push_back(sides);
        for (int k = 0; k < sides; ++k) {
            mesh_.faceVertexIndices.push_back(base + (start ? sides - 1 - k : k));
        }
    }

    void addRibbon(const std::vector<Station>& stations) {
        const std::size_t n = stations.size();
        const int base = int(mesh_.points.size());
        for (std::size_t i = 0; i < n; ++i) {
            const Station& s = stations[i];
            Vec3d side = cross(along_[i], Vec3d(s.normal));
            if (!(length(side) > 1e-9 * length(Vec3d(s.normal)))) {
                Vec3d other; // a normal along the curve, or none
                orthonormalBasis(along_[i], side, other);
            }
            side = normalize(side);
            const Vec3d normal = cross(side, along_[i]);
            for (const double sign : {-1.0, 1.0}) {
                addPoint(Vec3d(s.at) + side * (sign * double(s.radius)), normal, s.color);
            }
        }
        for (std::size_t i = 0; i + (periodic_ ? 0 : 1) < n; ++i) {
            const int low = base + 2 * int(i), high = base + 2 * int((i + 1) % n);
            addQuad(low, low + 1, high + 1, high);
        }
    }

    const CurveSet& curves_;
    CurveRepairs& repairs_;
    const bool periodic_;
    bool ribbons_ = false;
    CurveSet::Primvar<float> widths_;
    CurveSet::Primvar<Rgb> colors_;
    CurveSet::Primvar<Vec3f> normals_;
    Detail detail_ = {};
    std::vector<Vec3d> before_, after_, along_; // of the strand at hand
    ControlMesh mesh_;
};

} // namespace

std::size_t CurveSet::valueCount(Interpolation interpolation) const {
    std::size_t count = 0;
    switch (interpolation) {
    case Interpolation::Constant:
        return 1;
    case Interpolation::Uniform:
        return vertexCounts.size();
    case Interpolation::Vertex:
        return points.size();
    case Interpolation::Varying:
        if (basis == Basis::Linear) {
            return points.size();
        }
        for (int vertices : vertexCounts) {
            count += std::size_t(varyingsOf(basis, wrap, vertices));
        }
        break;
    }
    return count;
}

std::string CurveRepairs::summary() const {
    std::string text;
    const auto say = [&text](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
    const auto sayCount = [&say](int count, const char* what) {
        if (count > 0) {
            say(std::to_string(count) + (count == 1 ? " curve " : " curves ") + "left out (" + what + ")");
        }
    };
    sayCount(wrongCounts, "the number of vertices does not fit");
    sayCount(badPoints, "points that are not there or not finite");
    sayCount(withoutExtent, "no length or no width");
    for (const auto& [dropped, name] :
         {std::pair(droppedWidths, "widths"), {droppedColors, "displayColor"}, {droppedNormals, "normals"}}) {
        if (dropped) {
            say(std::string(name) + " ignored (wrong count)");
        }
    }
    if (nonFiniteValues > 0) {
        say(std::to_string(nonFiniteValues) + " widths, colors or normals that are not usable set to zero");
    }
    if (everyNth > 1) {
        say("too many curves, only one in " + std::to_string(everyNth) + " is drawn");
    } else if (coarser) {
        say("many curves, drawn with less detail");
    }
    return text;
}

ControlMesh tessellate(const CurveSet& curves, int level, std::size_t maxTriangles, CurveRepairs& repairs) {
    return Tessellation(curves, repairs).run(level, maxTriangles);
}

} // namespace stf
