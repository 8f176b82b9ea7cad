// A tracer to begin with: hit and depth of the spheres of a scene.
//
//     g++ -std=c++17 -O2 stub.cpp -o stub        (Debian: g++, nlohmann-json3-dev)
//     ./stub scene.json OUT                      OUT becomes a folder: hit.npy, depth.npy

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

using Vec = std::array<double, 3>;

double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// S8: the smallest positive root, evaluated so that far and small spheres keep their digits (E8).
double sphere_t(const Vec& P0, const Vec& d, const Vec& C, double R) {
    constexpr double INF = std::numeric_limits<double>::infinity();
    Vec L{C[0] - P0[0], C[1] - P0[1], C[2] - P0[2]};
    double a = dot(d, d), b = dot(d, L), k = b / a;
    Vec q{L[0] - k * d[0], L[1] - k * d[1], L[2] - k * d[2]};  // from the line to C
    double quarter_delta = a * (R * R - dot(q, q));
    if (quarter_delta < 0) return INF;
    double larger = b + std::copysign(std::sqrt(quarter_delta), b);
    double first = larger / a, second = larger == 0 ? 0 : (dot(L, L) - R * R) / larger;
    if (first > second) std::swap(first, second);
    return first > 0 ? first : second > 0 ? second : INF;
}

// NumPy's format: rows from the top, little-endian. "|b1" is bool, "<f8" is double.
template <class T>
void write_npy(const std::filesystem::path& path, const std::string& type,
               const std::vector<T>& values, int ny, int nx) {
    std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" +
                         std::to_string(ny) + ", " + std::to_string(nx) + "), }";
    header.resize(117, ' ');
    std::ofstream file(path, std::ios::binary);
    file << "\x93NUMPY\x01" << '\0' << '\x76' << '\0' << header << '\n';  // 0x76 = 117 + 1
    file.write(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    nlohmann::json scene = nlohmann::json::parse(std::ifstream(argv[1])), s = scene["screen"];
    Vec P0 = s["P0"], u = s["u"], v = s["v"], n = s["n"];
    double nu = s["nu"], l = s["l"], r = s["r"], b = s["b"], t = s["t"];
    int nx = s["nx"], ny = s["ny"];
    std::vector<std::pair<Vec, double>> spheres;
    for (const auto& thing : scene["objects"])
        if (thing["type"] == "sphere") spheres.push_back({thing["center"], thing["radius"]});
    // Go on here: "triangle" (S9), "polygon" (S10, S11), "mesh"; and below, beside hit and depth,
    // object, t, position, normal, shadow (S12), … See README.md for names and types.
    std::vector<char> hit;
    std::vector<double> depth;
    for (int row = 0; row < ny; ++row)  // the image's rows start at the top ...
        for (int i = 0; i < nx; ++i) {
            int j = ny - 1 - row;  // ... and the screen's at the bottom (S2)
            double x = l + (r - l) / nx * (i + 0.5), y = b + (t - b) / ny * (j + 0.5);
            Vec d;  // S3, S5: not normalised, t = 1 at the screen
            for (int k = 0; k < 3; ++k) d[k] = x * u[k] + y * v[k] + nu * n[k];
            double nearest = std::numeric_limits<double>::infinity();
            for (const auto& [C, R] : spheres) nearest = std::min(nearest, sphere_t(P0, d, C, R));
            hit.push_back(nearest < std::numeric_limits<double>::infinity());
            depth.push_back(nearest * std::abs(nu));
        }
    std::filesystem::path out = argv[2];
    std::filesystem::create_directories(out);
    write_npy(out / "hit.npy", "|b1", hit, ny, nx);
    write_npy(out / "depth.npy", "<f8", depth, ny, nx);
}
