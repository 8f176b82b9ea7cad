// The lecture in C++17, one file: the rules S1 to S16 in the order in which they are taught.
//
//     g++ -std=c++17 -O2 tracer.cpp -o tracer        (Debian: g++, nlohmann-json3-dev)
//     ./tracer scene.json OUT
//
// OUT becomes a folder: hit.png and shadow.png, black and white, and for each other quantity
// NAME.pfm with float32 numbers. All is computed in double; only the files are float32.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double INF = std::numeric_limits<double>::infinity();
constexpr double NaN = std::numeric_limits<double>::quiet_NaN();

// ---------------------------------------------------------------- vectors

struct Vec {
    double x = 0, y = 0, z = 0;
    double operator[](int k) const { return k == 0 ? x : k == 1 ? y : z; }
};

Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
Vec operator*(double k, Vec a) { return {k * a.x, k * a.y, k * a.z}; }
Vec operator*(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double norm(Vec a) { return std::sqrt(dot(a, a)); }
Vec unit(Vec a) { double length = norm(a); return {a.x / length, a.y / length, a.z / length}; }
Vec least(Vec a, Vec b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec most(Vec a, Vec b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }
double largest(Vec a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

// ---------------------------------------------------------------- the scene

struct Ray { Vec P0, d; };

struct Screen { Vec P0, u, v, n; double nu, l, r, b, t; int nx, ny; };

struct Material {
    Vec ambient, diffuse, specular;
    int shininess;
    double k_r, k_t, ior, alpha;  // ior is NaN where the material has none
};

// A sphere (C, R), or a triangle (a, b, c) in the plane through `a` with normal N.
struct Primitive {
    bool sphere;
    int object, triangle;
    Vec C; double R;
    Vec a, b, c, N;
    Vec lower, upper;
};

struct Hit {
    double t = INF;
    int object = -1, triangle = -1;
    double beta = NaN, gamma = NaN;
    const Primitive* on = nullptr;
    explicit operator bool() const { return on != nullptr; }
};

struct Node { Vec lower, upper; int left, right, first, count; };

struct Scene {
    Screen screen;
    Vec light, light_color, background, shadow_color;
    bool own_shadow_color;
    double epsilon;
    int max_depth;
    std::vector<Material> material;  // of each object
    std::vector<Primitive> primitives;
    std::vector<Node> nodes;  // a tree of boxes around them; the root is the first
};

// ---------------------------------------------------------------- S1–S3, S5: the primary ray

Ray primary_ray(const Screen& s, int i, int j) {
    double u = s.l + (s.r - s.l) / s.nx * (i + 0.5);  // (1); row j = 0 is the bottom
    double v = s.b + (s.t - s.b) / s.ny * (j + 0.5);
    return {s.P0, u * s.u + v * s.v + s.nu * s.n};  // (2) d = P − P0, so that t = 1 at the screen
}

// ---------------------------------------------------------------- S6, S8–S11: what a ray meets

// S8. Δ/4 = (d·d)(R² − q·q), q being the vector from the line to C, keeps its digits where
// b² − ac cancels; and so does the second root as c/a over the first (E8).
double sphere_t(const Ray& ray, const Primitive& s, double t0) {
    Vec L = s.C - ray.P0;
    double a = dot(ray.d, ray.d), b = dot(ray.d, L), c = dot(L, L) - s.R * s.R;
    Vec q = L - (b / a) * ray.d;
    double quarter_delta = a * (s.R * s.R - dot(q, q));
    if (quarter_delta < 0) return INF;
    double larger = b + std::copysign(std::sqrt(quarter_delta), b);
    double first = larger / a, second = larger == 0 ? 0 : c / larger;
    double near = std::min(first, second), far = std::max(first, second);
    if (near >= t0 && near > 0) return near;
    return far >= t0 && far > 0 ? far : INF;
}

// S9, S10. 1−β−γ, β and γ are quotients of the volumes that d spans with the edges seen from P0.
// A volume only changes its sign when its edge is walked backwards: no ray slips between the two
// triangles that share an edge. A polygon's fan (S11) is met in the polygon's own plane.
Hit triangle_hit(const Ray& ray, const Primitive& p, double t0) {
    Vec A = p.a - ray.P0, B = p.b - ray.P0, C = p.c - ray.P0;
    double w_a = dot(ray.d, cross(B + C, p.b - p.c));
    double w_b = dot(ray.d, cross(C + A, p.c - p.a));
    double w_c = dot(ray.d, cross(A + B, p.a - p.b));
    bool inside = (w_a >= 0 && w_b >= 0 && w_c >= 0) || (w_a <= 0 && w_b <= 0 && w_c <= 0);
    double total = w_a + w_b + w_c, slope = dot(ray.d, p.N);
    if (!inside || total == 0 || slope == 0) return {};
    double t = dot(A, p.N) / slope;
    if (!(t >= t0 && t > 0 && t < INF)) return {};
    return {t, p.object, p.triangle, w_b / total, w_c / total, &p};
}

Hit primitive_hit(const Ray& ray, const Primitive& p, double t0) {
    if (!p.sphere) return triangle_hit(ray, p, t0);
    double t = sphere_t(ray, p, t0);
    return t < INF ? Hit{t, p.object, 0, NaN, NaN, &p} : Hit{};
}

bool before(const Hit& x, const Hit& y) {
    if (x.t != y.t) return x.t < y.t;
    return x.object != y.object ? x.object < y.object : x.triangle < y.triangle;
}

// Whether a ray may meet something in a box at a t of [t0, t1]. NaN, from 0 · ∞, cuts nothing off.
bool may_meet(const Node& box, const Ray& ray, Vec inverse, double t0, double t1) {
    constexpr double SLACK = 1 + 1e-12;  // far more than the roundings here
    double enter = t0, leave = t1;
    for (int k = 0; k < 3; ++k) {
        double x = (box.lower[k] - ray.P0[k]) * inverse[k];
        double y = (box.upper[k] - ray.P0[k]) * inverse[k];
        if (inverse[k] < 0) std::swap(x, y);
        if (x > enter) enter = x;
        if (y < leave) leave = y;
    }
    return enter <= leave * SLACK;
}

// RT(P0, d, t0, ∞): the first hit, or any hit where only its existence matters.
Hit RT(const Scene& scene, const Ray& ray, double t0, bool any = false) {
    Vec inverse{1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z};
    Hit best;
    std::vector<int> stack{0};
    while (!stack.empty()) {
        const Node& node = scene.nodes[stack.back()];
        stack.pop_back();
        if (!may_meet(node, ray, inverse, t0, best.t)) continue;
        for (int k = node.first; k < node.first + node.count; ++k) {
            Hit hit = primitive_hit(ray, scene.primitives[k], t0);
            if (hit && before(hit, best)) best = hit;
        }
        if (any && best) return best;
        if (node.left) stack.insert(stack.end(), {node.left, node.right});  // the root is no child
    }
    return best;
}

// ---------------------------------------------------------------- S14–S16: reflection, refraction

Vec reflect(Vec delta, Vec s) { return delta - 2 * dot(delta, s) * s; }

// S16 with s turned along δ (E1); false is total internal reflection (E2).
bool refract(Vec delta, Vec normal, double ior, Vec& direction) {
    double cosine = dot(delta, normal);
    bool leaving = cosine > 0;
    double ratio = leaving ? ior : 1 / ior;  // S15: ν / ν_t
    Vec s = leaving ? normal : -normal;
    cosine = std::abs(cosine);
    double radicand = 1 - ratio * ratio * (1 - cosine * cosine);
    if (radicand < 0) return false;
    direction = ratio * delta + (std::sqrt(radicand) - ratio * cosine) * s;
    return true;
}

// ---------------------------------------------------------------- S7, S12, S13: the colour

struct Point { Vec M, delta, normal, s; };  // s is the normal turned to the viewer

Point point_of(const Ray& ray, const Hit& hit) {
    Vec M = ray.P0 + hit.t * ray.d, delta = unit(ray.d);
    Vec normal = unit(hit.on->sphere ? M - hit.on->C : hit.on->N);
    return {M, delta, normal, dot(normal, delta) > 0 ? -normal : normal};
}

bool in_shadow(const Scene& scene, const Point& point) {
    return bool(RT(scene, {point.M, unit(-scene.light)}, scene.epsilon, true));
}

double power(double base, int exponent) {
    double result = 1;
    for (; exponent; exponent >>= 1, base *= base)
        if (exponent & 1) result *= base;
    return result;
}

Vec local_color(const Scene& scene, const Material& m, const Point& p) {
    if (in_shadow(scene, p)) return scene.own_shadow_color ? scene.shadow_color : m.ambient;
    Vec L = unit(-scene.light);
    double facing = dot(p.s, L);
    if (!(facing > 0)) return m.ambient;
    double highlight = std::max(0.0, dot(reflect(-L, p.s), -p.delta));
    return m.ambient +
           scene.light_color * (facing * m.diffuse + power(highlight, m.shininess) * m.specular);
}

Vec ray_color(const Scene& scene, const Ray& ray, const Hit& hit, int generation) {
    if (!hit) return scene.background;
    const Material& m = scene.material[hit.object];
    Point p = point_of(ray, hit);
    double k_r = m.k_r, k_t = m.k_t;
    Vec mirrored, transmitted, through;
    if (k_t > 0 && !refract(p.delta, p.normal, m.ior, through)) {
        k_r += k_t;
        k_t = 0;
    }
    auto onward = [&](Vec direction) {
        Ray next{p.M, direction};
        return ray_color(scene, next, RT(scene, next, scene.epsilon), generation + 1);
    };
    if (generation < scene.max_depth) {
        if (k_r > 0) mirrored = onward(reflect(p.delta, p.s));
        if (k_t > 0) transmitted = onward(through);
    }
    return (1 - k_r - k_t) * local_color(scene, m, p) + k_r * mirrored + k_t * transmitted;
}

// ---------------------------------------------------------------- reading the scene

Vec vec(const json& j) { return {j.at(0), j.at(1), j.at(2)}; }

struct Mesh { std::vector<Vec> vertices; std::vector<std::array<int, 3>> faces; };

void add_fan(Mesh& mesh, const std::vector<int>& corner) {
    for (size_t k = 1; k + 1 < corner.size(); ++k)
        mesh.faces.push_back({corner[0], corner[k], corner[k + 1]});
}

Mesh read_obj(std::istream& file) {
    Mesh mesh;
    for (std::string line, word; std::getline(file, line);) {
        std::istringstream words(line);
        words >> word;
        if (line.rfind("v ", 0) == 0) {
            Vec p;
            words >> p.x >> p.y >> p.z;
            mesh.vertices.push_back(p);
        } else if (line.rfind("f ", 0) == 0) {
            std::vector<int> corner;
            while (words >> word) {
                int index = std::stoi(word);  // up to the first slash
                corner.push_back(index > 0 ? index - 1 : int(mesh.vertices.size()) + index);
            }
            add_fan(mesh, corner);
        }
    }
    return mesh;
}

template <class T> double binary_number(std::istream& file, bool swap) {
    char bytes[sizeof(T)];
    file.read(bytes, sizeof(T));
    if (swap) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return double(value);
}

double ply_number(std::istream& file, const std::string& type, const std::string& format) {
    if (format == "ascii") {
        double value;
        file >> value;
        return value;
    }
    bool swap = format == "binary_big_endian";  // this machine is taken to be little-endian
    if (type == "char" || type == "int8") return binary_number<int8_t>(file, swap);
    if (type == "uchar" || type == "uint8") return binary_number<uint8_t>(file, swap);
    if (type == "short" || type == "int16") return binary_number<int16_t>(file, swap);
    if (type == "ushort" || type == "uint16") return binary_number<uint16_t>(file, swap);
    if (type == "int" || type == "int32") return binary_number<int32_t>(file, swap);
    if (type == "uint" || type == "uint32") return binary_number<uint32_t>(file, swap);
    if (type == "float" || type == "float32") return binary_number<float>(file, swap);
    if (type == "double" || type == "float64") return binary_number<double>(file, swap);
    throw std::runtime_error("PLY: unknown type " + type);
}

Mesh read_ply(std::istream& file) {
    struct Property { std::string name, type, count_type; };
    struct Element { std::string name; int rows; std::vector<Property> properties; };
    std::vector<Element> elements;
    std::string line, word, format;
    while (std::getline(file, line) && line.rfind("end_header", 0) != 0) {
        std::istringstream words(line);
        words >> word;
        if (word == "format") words >> format;
        if (word == "element") {
            elements.emplace_back();
            words >> elements.back().name >> elements.back().rows;
        }
        if (word == "property") {
            Property p;
            words >> p.type;
            if (p.type == "list") words >> p.count_type >> p.type;
            words >> p.name;
            elements.back().properties.push_back(p);
        }
    }
    Mesh mesh;
    for (const Element& element : elements)
        for (int row = 0; row < element.rows; ++row) {
            std::map<std::string, double> value;
            for (const Property& p : element.properties) {
                if (p.count_type.empty()) {
                    value[p.name] = ply_number(file, p.type, format);
                    continue;
                }
                std::vector<int> list(size_t(ply_number(file, p.count_type, format)));
                for (int& index : list) index = int(ply_number(file, p.type, format));
                if (element.name == "face" && p.name.rfind("vertex_ind", 0) == 0)
                    add_fan(mesh, list);
            }
            if (element.name == "vertex")
                mesh.vertices.push_back({value["x"], value["y"], value["z"]});
        }
    return mesh;
}

Mesh read_mesh(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot open " + path.string());
    if (path.extension() == ".obj") return read_obj(file);
    if (path.extension() == ".ply") return read_ply(file);
    throw std::runtime_error("neither .obj nor .ply: " + path.string());
}

Primitive triangle(int object, int number, Vec a, Vec b, Vec c, Vec N) {
    return {false, object, number, {}, 0, a, b, c, N, least(least(a, b), c), most(most(a, b), c)};
}

void add_object(Scene& scene, const json& o, int number, const fs::path& folder) {
    std::string type = o.at("type");
    if (type == "sphere") {
        Vec C = vec(o.at("center"));
        double R = o.at("radius");
        Vec r{R, R, R};
        scene.primitives.push_back({true, number, 0, C, R, {}, {}, {}, {}, C - r, C + r});
        return;
    }
    Mesh mesh;
    if (type == "mesh") {
        mesh = read_mesh(folder / std::string(o.at("file")));
        if (o.contains("transform") && !o["transform"].is_null())
            for (Vec& p : mesh.vertices) {
                const json& m = o["transform"];
                auto row = [&](int k) { return dot(vec(m[k]), p) + double(m[k][3]); };
                p = {row(0), row(1), row(2)};
            }
    } else {
        std::vector<int> corner;
        for (const json& p : o.at("vertices")) {
            corner.push_back(int(mesh.vertices.size()));
            mesh.vertices.push_back(vec(p));
        }
        add_fan(mesh, corner);
    }
    std::vector<Vec> normals;
    for (auto [i, j, k] : mesh.faces) {
        Vec a = mesh.vertices[i];
        normals.push_back(cross(mesh.vertices[j] - a, mesh.vertices[k] - a));
    }
    if (type == "polygon") {  // one plane for the whole fan: the longest normal says it best
        auto longer = [](Vec x, Vec y) { return dot(x, x) < dot(y, y); };
        Vec p = *std::max_element(normals.begin(), normals.end(), longer);
        std::fill(normals.begin(), normals.end(), p);
    }
    for (size_t k = 0; k < mesh.faces.size(); ++k) {
        auto [a, b, c] = mesh.faces[k];
        if (dot(normals[k], normals[k]) > 0)  // else degenerate: never hit
            scene.primitives.push_back(triangle(number, int(k), mesh.vertices[a],
                                                mesh.vertices[b], mesh.vertices[c], normals[k]));
    }
}

// A box around primitives first … first + count − 1, wider by `pad` than their roundings, and
// under it two boxes around the halves that lie on either side of its longest axis.
int build(Scene& scene, int first, int count, double pad) {
    Vec lower{INF, INF, INF}, upper{-INF, -INF, -INF};
    for (int k = first; k < first + count; ++k) {
        lower = least(lower, scene.primitives[k].lower);
        upper = most(upper, scene.primitives[k].upper);
    }
    int self = int(scene.nodes.size());
    Vec margin{pad, pad, pad}, size = upper - lower;
    scene.nodes.push_back({lower - margin, upper + margin, 0, 0, first, count});
    if (count <= 4) return self;
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    auto from = scene.primitives.begin() + first;
    std::nth_element(from, from + count / 2, from + count, [&](const auto& x, const auto& y) {
        return x.lower[axis] + x.upper[axis] < y.lower[axis] + y.upper[axis];
    });
    int left = build(scene, first, count / 2, pad);
    int right = build(scene, first + count / 2, count - count / 2, pad);
    scene.nodes[self].left = left;
    scene.nodes[self].right = right;
    scene.nodes[self].count = 0;
    return self;
}

Scene read_scene(const fs::path& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error("cannot open " + path.string());
    json document = json::parse(file);
    const json& s = document.at("screen");
    Scene scene;
    scene.screen = {vec(s.at("P0")), vec(s.at("u")), vec(s.at("v")), vec(s.at("n")),
                    s.at("nu"), s.at("l"), s.at("r"), s.at("b"), s.at("t"), s.at("nx"), s.at("ny")};
    scene.light = vec(document.at("light").at("direction"));
    scene.light_color = vec(document["light"].at("color"));
    scene.background = vec(document.at("background"));
    scene.own_shadow_color = !document.at("shadow_color").is_null();
    if (scene.own_shadow_color) scene.shadow_color = vec(document["shadow_color"]);
    scene.epsilon = document.at("epsilon");
    scene.max_depth = document.at("max_depth");
    for (const json& o : document.at("objects")) {
        const json& m = document.at("materials").at(std::string(o.at("material")));
        double ior = m.at("ior").is_null() ? NaN : double(m["ior"]);
        scene.material.push_back({vec(m.at("ambient")), vec(m.at("diffuse")),
                                  vec(m.at("specular")), m.at("shininess"), m.at("reflectance"),
                                  m.at("transmittance"), ior, m.at("alpha")});
        add_object(scene, o, int(scene.material.size()) - 1, path.parent_path());
    }
    double reach = largest(scene.screen.P0);
    for (const Primitive& p : scene.primitives)
        reach = std::max({reach, largest(p.lower), largest(p.upper)});
    build(scene, 0, int(scene.primitives.size()), reach * 1e-12);
    return scene;
}

// ---------------------------------------------------------------- S4: the image

struct Image { int components; double miss; std::vector<double> values; };
using Frame = std::map<std::string, Image>;

Frame blank_frame(int pixels) {
    Frame frame;
    auto add = [&](const char* name, int components, double miss) {
        frame[name] = {components, miss, std::vector<double>(size_t(pixels) * components, miss)};
    };
    for (const char* name : {"hit", "alpha"}) add(name, 1, 0);
    for (const char* name : {"object", "triangle", "shadow", "reflection_object", "tir",
                             "refraction_object"})
        add(name, 1, -1);
    for (const char* name : {"t", "depth", "distance", "reflection_t", "refraction_t"})
        add(name, 1, INF);
    for (const char* name : {"ray", "position", "normal", "barycentric", "reflection",
                             "refraction", "color"})
        add(name, 3, NaN);
    return frame;
}

void trace_pixel(const Scene& scene, const Ray& ray, int pixel, Frame& frame) {
    auto put = [&](const char* name, double value) { frame[name].values[pixel] = value; };
    auto put3 = [&](const char* name, Vec value) {
        for (int k = 0; k < 3; ++k) frame[name].values[size_t(pixel) * 3 + k] = value[k];
    };
    Hit hit = RT(scene, ray, 0);
    put3("ray", unit(ray.d));
    put3("color", ray_color(scene, ray, hit, 0));
    if (!hit) return;
    Point p = point_of(ray, hit);
    const Material& m = scene.material[hit.object];
    put("hit", 1);
    put("object", hit.object);
    put("triangle", hit.triangle);
    put("t", hit.t);
    put("depth", hit.t * std::abs(scene.screen.nu));
    put("distance", hit.t * norm(ray.d));
    put("alpha", m.alpha);
    put3("position", p.M);
    put3("normal", p.normal);
    put3("barycentric", {hit.beta, hit.gamma, 0});  // a PFM has one component or three
    put("shadow", in_shadow(scene, p));
    Vec rho = reflect(p.delta, p.s), through;
    Hit mirrored = RT(scene, {p.M, rho}, scene.epsilon);
    put3("reflection", rho);
    put("reflection_object", mirrored.object);
    put("reflection_t", mirrored.t);
    if (std::isnan(m.ior)) return;
    bool passes = refract(p.delta, p.normal, m.ior, through);
    put("tir", !passes);
    if (!passes) return;
    Hit behind = RT(scene, {p.M, through}, scene.epsilon);
    put3("refraction", through);
    put("refraction_object", behind.object);
    put("refraction_t", behind.t);
}

Frame render(const Scene& scene) {
    const Screen& s = scene.screen;
    Frame frame = blank_frame(s.nx * s.ny);
    for (int row = 0; row < s.ny; ++row)  // row 0 is the top of the image, j = 0 its bottom
        for (int i = 0; i < s.nx; ++i)
            trace_pixel(scene, primary_ray(s, i, s.ny - 1 - row), row * s.nx + i, frame);
    return frame;
}

// ---------------------------------------------------------------- writing the folder

// Rows from the bottom; the scale −1 says that numbers are little-endian.
void write_pfm(const fs::path& path, const Image& image, int nx, int ny) {
    std::ofstream file(path, std::ios::binary);
    file << (image.components == 3 ? "PF" : "Pf") << "\n" << nx << " " << ny << "\n-1.0\n";
    size_t row_length = size_t(nx) * image.components;
    for (int row = ny - 1; row >= 0; --row) {
        auto from = image.values.begin() + row * row_length;
        std::vector<float> line(from, from + row_length);
        file.write(reinterpret_cast<const char*>(line.data()), line.size() * sizeof(float));
    }
    if (!file) throw std::runtime_error("cannot write " + path.string());
}

std::string big_endian(uint32_t value) {
    return {char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
}

std::string png_chunk(const std::string& name_and_data) {
    uint32_t crc = ~0u;
    for (unsigned char byte : name_and_data) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return big_endian(uint32_t(name_and_data.size() - 4)) + name_and_data + big_endian(~crc);
}

// A row as a stored block of zlib's format: no compression, and no library either.
void write_mask(const fs::path& path, const Image& image, int nx, int ny) {
    std::string data = "\x78\x01";
    uint32_t low = 1, high = 0;  // Adler-32
    for (int row = 0; row < ny; ++row) {
        std::string line(1, '\0');  // the filter: none
        for (int i = 0; i < nx; ++i) line += image.values[row * nx + i] == 1 ? '\xFF' : '\0';
        for (unsigned char byte : line) {
            low = (low + byte) % 65521;
            high = (high + low) % 65521;
        }
        auto size = uint16_t(line.size()), rest = uint16_t(~size);
        data += row + 1 == ny ? '\1' : '\0';
        data += {char(size), char(size >> 8), char(rest), char(rest >> 8)};
        data += line;
    }
    std::string header = big_endian(nx) + big_endian(ny);
    header += {8, 0, 0, 0, 0};  // 8 bits of grey
    std::ofstream file(path, std::ios::binary);
    file << "\x89PNG\r\n\x1A\n" << png_chunk("IHDR" + header)
         << png_chunk("IDAT" + data + big_endian(high << 16 | low)) << png_chunk("IEND");
    if (!file) throw std::runtime_error("cannot write " + path.string());
}

int main(int argc, char** argv) try {
    if (argc != 3) throw std::runtime_error("usage: tracer scene.json OUT");
    Scene scene = read_scene(argv[1]);
    Frame frame = render(scene);
    fs::path out = argv[2];
    fs::create_directories(out);
    for (const auto& [name, image] : frame) {
        bool mask = name == "hit" || name == "shadow";
        (mask ? write_mask : write_pfm)(out / (name + (mask ? ".png" : ".pfm")), image,
                                        scene.screen.nx, scene.screen.ny);
    }
} catch (const std::exception& error) {
    std::cerr << "tracer: " << error.what() << "\n";
    return 1;
}
