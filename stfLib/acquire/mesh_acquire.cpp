// SPDX-License-Identifier: Apache-2.0
#include "stfLib/acquire/mesh_acquire.h"

#include "stfLib/acquire/mesh_distance.h"
#include "stfLib/acquire/mesh_scatter.h"
#include "stfLib/acquire/mesh_shapes.h"
#include "stfLib/base/near_names.h"
#include "stfLib/optics/property_table.h"
#include "stfLib/volume/material_blend.h"

#include <map>
#include <memory>
#include <numeric>
#include <sstream>

namespace stf {

namespace {

/// Triangles of a shape: 20 * 4^detail of a sphere; scattered ones are small.
constexpr int kDetail = 4, kScatteredDetail = 3;
constexpr double kBytesPerTriangle = 200; ///< with its points, its places in columns and in a tree

/// A mesh with one material, ready for the tile.
struct Placed {
    std::unique_ptr<MeshColumns> columns;
    Material material;
    int priority = 0;
    bool body = false, surface = false;
};

class Acquisition {
public:
    Acquisition(const MeshRecipe& recipe, const MeshReader& reader, double maxBytes, Progress& progress,
                const MessageSink& messages)
        : recipe_(recipe), reader_(reader), maxBytes_(maxBytes), progress_(progress), messages_(messages),
          table_(recipe.materials.empty() ? PropertyTable::builtIn() : PropertyTable::read(recipe.materials)),
          grid_{recipe.size, recipe.voxelMm} {}

    MeshAcquisition run() {
        const Material matrix = materialOf(recipe_.matrix);
        checkRecipe(matrix);
        startVolume(matrix);
        for (std::size_t i = 0; i < recipe_.meshes.size(); ++i) {
            progress_.update("read", double(i) / double(recipe_.meshes.size()));
            place(recipe_.meshes[i]);
        }
        std::stable_sort(placed_.begin(), placed_.end(),
                         [](const Placed& a, const Placed& b) { return a.priority < b.priority; });
        CoverBody body = makeBody(matrix);
        std::vector<CoverObject> objects;
        for (const Placed& p : placed_) {
            if (!p.body) {
                objects.push_back({p.columns.get(), p.material.isVoid() && p.surface ? -1 : slotOf(p.material)});
            }
        }
        fill(body, objects);
        return std::move(result_);
    }

private:
    Material materialOf(const MaterialChoice& choice) const {
        return choice.given ? *choice.given : table_.find(choice.name);
    }

    void checkRecipe(const Material& matrix) const {
        const double voxels = double(grid_.size.x) * grid_.size.y * grid_.size.z;
        // Fractions of all materials, coefficients, two fields of distances.
        const double bytes = voxels * (4.0 * double(recipe_.meshes.size() + 2) + 32 + 12);
        if (voxels > double(kMaxVoxels) || bytes > maxBytes_) {
            std::ostringstream s;
            s << "a tile of " << grid_.size.x << " x " << grid_.size.y << " x " << grid_.size.z << " voxels with "
              << recipe_.meshes.size() << " meshes takes " << std::ceil(bytes / 1e6) << " MB, "
              << std::floor(maxBytes_ / 1e6) << " MB and " << kMaxVoxels << " voxels are allowed";
            throw Error(s.str());
        }
        const bool bodies =
            std::any_of(recipe_.meshes.begin(), recipe_.meshes.end(), [](const MeshEntry& e) { return e.body; });
        if (recipe_.top == MeshRecipe::Top::Relief && matrix.isVoid()) {
            throw Error("a relief needs a matrix that is not a void: it is the surface of the matrix");
        }
        if (bodies && recipe_.top != MeshRecipe::Top::Geometry) {
            throw Error("a mesh is marked 'body', which needs \"top\": \"geometry\"");
        }
        if (recipe_.top == MeshRecipe::Top::Geometry && bodies == matrix.isVoid()) {
            throw Error(bodies
                            ? "a mesh is marked 'body', but the matrix that would be inside it is a void"
                            : "with \"top\": \"geometry\" the matrix fills the meshes marked 'body', and there is none "
                              "(with matrix \"none\" the meshes alone are the material)");
        }
    }

    void startVolume(const Material& matrix) {
        BaseVolume& v = result_.volume;
        v.name = recipe_.name;
        v.size = recipe_.size;
        v.voxelMm = recipe_.voxelMm;
        const Material core = recipe_.core.empty() ? matrix : materialOf(recipe_.core);
        v.coreSigmaA = core.sigmaA;
        v.coreSigmaSPrime = core.sigmaSPrime();
    }

    /// All parts that an entry asks for.
    std::vector<MeshPart> partsOf(const MeshSource& source, bool scattered) {
        if (source.file.empty()) {
            return {
                {source.label(), {}, {}, makeShape(source, grid_.extentMm(), scattered ? kScatteredDetail : kDetail)}};
        }
        auto at = files_.find(source.file);
        if (at == files_.end()) {
            at = files_.emplace(source.file, reader_(source.file)).first;
        }
        if (source.part.empty()) {
            return at->second;
        }
        std::vector<MeshPart> parts;
        std::vector<std::string> names;
        for (const MeshPart& p : at->second) {
            names.push_back(p.name);
            if (p.name == source.part || p.path == source.part || p.path.rfind(source.part + "/", 0) == 0) {
                parts.push_back(p);
            }
        }
        if (parts.empty()) {
            throw Error(source.file + ": has no part named '" + source.part + "'" + didYouMean(source.part, names));
        }
        return parts;
    }

    /// Parts by the names of their materials; one group without a name where the recipe says what they are.
    static std::map<std::string, TriangleMesh> groups(const std::vector<MeshPart>& parts, bool byName,
                                                      const std::string& label) {
        std::map<std::string, TriangleMesh> result;
        for (const MeshPart& p : parts) {
            if (byName && p.material.empty()) {
                throw Error(label + ": part '" + p.name +
                            "' names no material, and the recipe gives none ('material')");
            }
            append(result[byName ? p.material : std::string()], p.mesh);
        }
        return result;
    }

    void place(const MeshEntry& entry) {
        const std::string label = entry.source.label();
        const auto grouped = groups(partsOf(entry.source, entry.scatter.has_value()), entry.material.empty(), label);
        std::vector<std::pair<MendedMesh, Material>> mended;
        TriangleMesh all;
        for (const auto& [name, mesh] : grouped) {
            mended.emplace_back(repair(mesh, label),
                                materialOf(entry.material.empty() ? MaterialChoice{name, {}} : entry.material));
            append(all, mended.back().first.mesh);
        }
        Transform placement;
        std::vector<Transform> copies;
        try {
            placement = placementOf(entry.placement, all, grid_.extentMm());
            copies = copiesOf(entry, transformed(all, placement), mended, placement, label);
        } catch (const Error& e) {
            throw Error(label + ": " + e.what());
        }
        for (auto& [mesh, material] : mended) {
            addPlaced(entry, mesh, material, placement, copies, label);
        }
    }

    std::vector<Transform> copiesOf(const MeshEntry& entry, const TriangleMesh& placed,
                                    const std::vector<std::pair<MendedMesh, Material>>& mended,
                                    const Transform& placement, const std::string& label) const {
        if (!entry.scatter) {
            return {Transform()};
        }
        ScatteredBody body;
        body.middle = boundsOf(placed).middle();
        for (const Vec3d& p : placed.points) {
            body.radius = std::max(body.radius, length(p - body.middle));
        }
        for (const auto& [mesh, unused] : mended) {
            body.volume += std::abs(mesh.repair.volume * placement.determinant());
        }
        ScatterResult s = scatter(*entry.scatter, body, grid_.extentMm());
        if (s.leftOut) {
            report(messages_, Severity::Warning,
                   label + ": no place was found for " + std::to_string(s.leftOut) + " of " +
                       std::to_string(s.leftOut + s.copies.size()) + " copies that are to be kept apart");
        }
        return std::move(s.copies);
    }

    void addPlaced(const MeshEntry& entry, const MendedMesh& mesh, const Material& material, const Transform& placement,
                   const std::vector<Transform>& copies, const std::string& label) {
        const double triangles =
            double(mesh.mesh.triangles.size() + mesh.caps.triangles.size()) * double(copies.size());
        if (triangles * kBytesPerTriangle > maxBytes_) {
            throw Error(label + ": " + std::to_string(copies.size()) + " copies of " +
                        std::to_string(mesh.mesh.triangles.size()) + " triangles take more than the " +
                        std::to_string(std::int64_t(maxBytes_ / 1e6)) + " MB allowed");
        }
        AcquiredMesh info{label, material.name, mesh.repair, copies.size(), 0};
        MendedMesh tiled;
        tiled.repair = mesh.repair;
        for (const Transform& copy : copies) {
            const Transform t = compose(copy, placement);
            info.volumeMm3 += std::abs(mesh.repair.volume * t.determinant());
            append(tiled.mesh, transformed(mesh.mesh, compose(depthInward(), t)));
            append(tiled.caps, transformed(mesh.caps, compose(depthInward(), t)));
        }
        warn(info, boundsOf(tiled.mesh));
        result_.meshes.push_back(info);
        Placed p;
        p.columns = columnsOf(std::move(tiled), label);
        p.material = material;
        p.priority = entry.priority;
        p.body = entry.body;
        p.surface = entry.surface;
        placed_.push_back(std::move(p));
    }

    std::unique_ptr<MeshColumns> columnsOf(MendedMesh mesh, const std::string& label) const {
        try {
            return std::make_unique<MeshColumns>(std::move(mesh), grid_, maxBytes_);
        } catch (const Error& e) {
            throw Error(label + ": " + e.what());
        }
    }

    /// From the coordinates of a recipe to those of the tile.
    static Transform depthInward() {
        Transform t;
        t.z = {0, 0, -1};
        return t;
    }

    void warn(const AcquiredMesh& mesh, const Box3d& box) const {
        if (!mesh.repair.sound()) {
            report(messages_, mesh.repair.holes ? Severity::Warning : Severity::Info,
                   mesh.label + ": " + mesh.repair.summary());
        }
        std::ostringstream s;
        if (box.hi.z <= 0 || box.lo.z >= grid_.extentMm().z) {
            s << mesh.label << ": lies wholly " << (box.hi.z <= 0 ? "above" : "below") << " the tile (z from "
              << -box.hi.z << " to " << -box.lo.z << " mm, the tile from " << -grid_.extentMm().z << " to 0)";
        } else if (mesh.copies == 1 && maxComponent(box.size()) < minComponent(grid_.voxelMm)) {
            s << mesh.label << ": is smaller than a voxel (" << maxComponent(box.size()) << " mm)";
        }
        if (!s.str().empty()) {
            report(messages_, Severity::Warning, s.str());
        }
    }

    int slotOf(const Material& material) {
        for (std::size_t i = 0; i < slots_.size(); ++i) {
            const Material& m = slots_[i];
            if (m.name == material.name && m.sigmaA == material.sigmaA && m.sigmaS == material.sigmaS &&
                m.g == material.g && m.ior == material.ior) {
                return int(i);
            }
        }
        slots_.push_back(material);
        return int(slots_.size()) - 1;
    }

    CoverBody makeBody(const Material& matrix) {
        CoverBody body;
        body.material = matrix.isVoid() ? -1 : slotOf(matrix);
        if (recipe_.top == MeshRecipe::Top::Geometry) {
            body.kind = CoverBody::Kind::Meshes;
            for (const Placed& p : placed_) {
                if (p.body) {
                    body.meshes.push_back(p.columns.get());
                }
            }
        } else if (recipe_.top == MeshRecipe::Top::Relief) {
            body.kind = CoverBody::Kind::Relief;
            makeRelief(body);
        }
        return body;
    }

    void makeRelief(CoverBody& body) {
        const std::string label = recipe_.relief.label();
        TriangleMesh all;
        for (const MeshPart& p : partsOf(recipe_.relief, false)) {
            append(all, p.mesh);
        }
        MendedMesh mended = repair(all, label);
        // A relief is an upper envelope, of a sheet as well as of a body: it has no holes to close.
        mended.caps = {};
        Transform t;
        try {
            t = reliefPlacementOf(recipe_.reliefPlacement, mended.mesh, grid_.extentMm());
        } catch (const Error& e) {
            throw Error(label + ": " + e.what());
        }
        mended.mesh = transformed(mended.mesh, compose(depthInward(), t));
        const Box3d box = boundsOf(mended.mesh);
        if (box.lo.z >= grid_.extentMm().z) {
            std::ostringstream s;
            s << label << ": as a relief it lies below the tile (its highest point at z = " << -box.lo.z
              << " mm, the tile's bottom at " << -grid_.extentMm().z << ")";
            throw Error(s.str());
        }
        result_.meshes.push_back({label, "relief", mended.repair, 1, 0});
        body.reliefFloor = std::clamp(box.hi.z, 0.0, grid_.extentMm().z);
        relief_ = columnsOf(std::move(mended), label);
        body.meshes = {relief_.get()};
    }

    void fill(const CoverBody& body, const std::vector<CoverObject>& objects) {
        BaseVolume& v = result_.volume;
        if (std::all_of(slots_.begin(), slots_.end(), [](const Material& m) { return m.isVoid(); })) {
            throw Error("there is no material: neither a matrix nor a mesh that is not a void");
        }
        TileCover cover = coverTile(body, objects, grid_, int(slots_.size()), progress_);
        if (cover.reliefMissing > 0) {
            std::ostringstream s;
            s << recipe_.relief.label() << ": the relief leaves " << 100 * cover.reliefMissing
              << " % of the tile open, which is filled at its lowest height";
            report(messages_, Severity::Warning, s.str());
        }
        for (std::size_t i = 0; i < slots_.size(); ++i) {
            result_.shares.push_back({slots_[i].name, cover.meanShare[i]});
        }
        const bool hollow =
            std::any_of(objects.begin(), objects.end(), [](const CoverObject& o) { return o.material < 0; });
        if (recipe_.top != MeshRecipe::Top::Flat || hollow) {
            v.surface = signedDistance(body, objects, cover.protrudes, grid_, progress_);
        }
        progress_.update("blend", 0);
        blendMaterials(v, slots_, cover.fractions);
        validate(v);
    }

    const MeshRecipe& recipe_;
    const MeshReader& reader_;
    const double maxBytes_;
    Progress& progress_;
    const MessageSink& messages_;
    const PropertyTable table_;
    const TileGrid grid_;
    std::map<std::string, std::vector<MeshPart>> files_;
    std::vector<Placed> placed_;
    std::unique_ptr<MeshColumns> relief_;
    std::vector<Material> slots_;
    MeshAcquisition result_;
};

} // namespace

MeshAcquisition acquireMesh(const MeshRecipe& recipe, const MeshReader& reader, double maxBytes, Progress& progress,
                            const MessageSink& messages) {
    return Acquisition(recipe, reader, maxBytes, progress, messages).run();
}

} // namespace stf
