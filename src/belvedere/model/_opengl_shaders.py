"""Shaders of `opengl_rasterize`. Private.

Tables lie in textures of ``1 << BITS`` columns, row after row; `fetch` finds an element by its
number. The first lines, with the version and `BITS`, are written before compiling.
"""

from __future__ import annotations

VISIBILITY_VERTEX = """
// Moves vertices as `_raster_setup.project` does. Depth is near / Z: 1 at the near plane, 0 at
// infinity.
uniform mat3 pixels_from_world;
uniform vec3 eye;
uniform vec2 size;
uniform float near;
in vec3 position;

void main() {
    vec3 q = pixels_from_world * (position - eye);  // u Z, v Z, Z
    gl_Position = vec4((2.0 * q.xy + q.z) / size - q.z, 2.0 * near - q.z, q.z);
}
"""

VISIBILITY_FRAGMENT = """
// Writes which face it is: number `first` of its list and those after it are drawn.
uniform isampler2D face_of;
uniform int first;
out int face;

void main() {
    int n = first + gl_PrimitiveID;
    face = texelFetch(face_of, ivec2(n & MASK, n >> BITS), 0).r;
}
"""

EVERY_PIXEL = """
// One triangle over the whole picture.
void main() {
    gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 2.0 * float(gl_VertexID & 2) - 1.0,
                       0.0, 1.0);
}
"""

NO_FACE = """
// Clearing would not do: OpenGL leaves open what a float clears whole numbers to.
out int face;

void main() { face = -1; }
"""

SHADE = """
// Repeats `_shade_pixels.shade_pixels`, `_kernels.expose` and `_sky.sky_radiance`.
uniform isampler2D faces;       // of each pixel, -1 in the sky
uniform sampler2D depths;       // near / Z
uniform sampler2D planes;       // normal and height of each face
uniform sampler2D maps;         // 4 a face: slopes of s, t, u, v along x, y, z; values at 0
uniform sampler2D tints;        // 4 a face: the same of corner colors
uniform isampler2D records;     // 2 a face, see `_shade_pixels.CHART`
uniform sampler2D materials;    // 2 a material: base color and first level or -1, emission
uniform isampler2D levels;      // first texel, texels a row, width, height
uniform sampler2D texels;
uniform sampler2D soft;
uniform sampler2D sun;
uniform mat3 matrix;
uniform vec3 eye;
uniform vec3 sun_color;
uniform float near;
uniform float spread;
uniform float finest;
uniform int tinted;
out vec4 color;

ivec2 place(int n) { return ivec2(n & MASK, n >> BITS); }
vec4 fetch(sampler2D table, int n) { return texelFetch(table, place(n), 0); }

vec4 bilinear(sampler2D table, int first, int down, vec2 share) {
    vec4 upper = mix(fetch(table, first), fetch(table, first + 1), share.x);
    vec4 lower = mix(fetch(table, first + down), fetch(table, first + down + 1), share.x);
    return mix(upper, lower, share.y);
}

vec4 lattice(sampler2D table, int first, ivec2 shape, vec2 st) {
    vec2 at = st * vec2(shape - 1);
    vec2 cell = min(floor(at), vec2(max(shape - 2, ivec2(0))));
    return bilinear(table, first + int(cell.y) * shape.x + int(cell.x), shape.x, at - cell);
}

vec3 level_color(int level, vec2 uv) {
    ivec4 image = texelFetch(levels, place(level), 0);
    vec2 at = uv * vec2(image.zw) + 0.5;
    ivec2 cell = ivec2(at);
    return bilinear(texels, image.x + cell.y * image.y + cell.x, image.y, at - vec2(cell)).rgb;
}

vec3 texture_color(int first, vec2 uv, float level) {
    int whole = int(level);
    float share = level - float(whole);
    if (share > 0.98) whole += 1;
    vec3 fine = level_color(first + whole, uv);
    if (share < 0.02 || share > 0.98) return fine;
    return mix(fine, level_color(first + whole + 1, uv), share);
}

vec3 surface(int face, vec3 ray, ivec2 pixel) {
    vec4 plane = fetch(planes, face);
    float above = plane.w - dot(plane.xyz, eye);
    float delta = dot(plane.xyz, ray) / above;
    if (!(delta > 1e-9 && delta < 1e9)) delta = texelFetch(depths, pixel, 0).r / near;
    float depth = 1.0 / delta;
    vec3 at = eye + depth * ray;
    vec4 stuv = at.x * fetch(maps, 4 * face) + at.y * fetch(maps, 4 * face + 1)
        + at.z * fetch(maps, 4 * face + 2) + fetch(maps, 4 * face + 3);
    ivec4 chart = texelFetch(records, place(2 * face), 0);
    ivec4 other = texelFetch(records, place(2 * face + 1), 0);
    vec2 st = clamp(stuv.xy, 0.0, 1.0);
    vec3 light = lattice(soft, chart.x, chart.yz, st).rgb
        + lattice(sun, chart.w, other.xy, st).r * sun_color;
    vec4 material = fetch(materials, 2 * other.z);
    light *= material.rgb;
    if (material.a >= 0.0) {
        float size = dot(ray, ray);
        float facing = max(delta * abs(above) / sqrt(size), 0.04);
        float foot = depth * spread * intBitsToFloat(other.w);
        float level = 0.5 * log2(max(foot * foot * size / facing, 1e-12)) + 0.15;
        vec2 uv = clamp(stuv.zw - floor(stuv.zw), 0.0, 1.0);
        light *= texture_color(int(material.a), uv, clamp(level, 0.0, finest));
    }
    if (tinted != 0) {
        vec3 tint = (at.x * fetch(tints, 4 * face) + at.y * fetch(tints, 4 * face + 1)
            + at.z * fetch(tints, 4 * face + 2) + fetch(tints, 4 * face + 3)).rgb;
        light *= max(tint, vec3(0.0));
    }
    return light + fetch(materials, 2 * other.z + 1).rgb;
}

vec3 sky(vec3 ray) {
    float azimuth = atan(ray.y, ray.x);
    float rise = ray.z / sqrt(max(dot(ray.xy, ray.xy), 1e-12));
    float far = 0.085 + 0.030 * sin(3.0 * azimuth + 1.0) + 0.020 * sin(7.0 * azimuth)
        + 0.006 * sin(23.0 * azimuth + 2.0);
    float hills = 0.012 + 0.018 * sin(5.0 * azimuth + 0.6) + 0.009 * sin(17.0 * azimuth + 1.7)
        + 0.0045 * sin(61.0 * azimuth) + 0.0035 * sin(143.0 * azimuth + 0.5);
    if (rise > far) {
        float z = clamp(ray.z, 0.0, 1.0);
        float up = sqrt(z);
        vec3 air = mix(vec3(0.30, 0.55, 0.95), vec3(0.20, 0.40, 0.81), up)
            + vec3(0.62, 0.42, 0.08) * exp(-8.0 * max(ray.z, 0.0));
        vec2 drift = ray.xy / (ray.z + 0.25);
        float wisp = sin(4.0 * drift.x + 2.0 * ray.y) * sin(3.0 * drift.y + ray.x);
        return mix(air, vec3(0.98, 0.98, 0.99), 0.35 * max(wisp, 0.0));
    }
    if (rise > hills) {
        float deep = min((far - rise) * 6.0, 1.0);
        return vec3(0.40, 0.50, 0.58) - vec3(0.14, 0.10, 0.26) * deep;
    }
    float depth = 1.0 / (hills - rise + 0.05);
    float field = sin(2.3 * azimuth * depth + 1.3) * sin(1.1 * depth + 2.0 * azimuth);
    float patch_ = 0.025 * field + 0.02 * sin(9.0 * azimuth + 0.6 * depth);
    float trees = max(0.0, 1.0 - (hills - rise) * (26.0 + 9.0 * sin(37.0 * azimuth)));
    float leafy = 0.03 * sin(311.0 * azimuth) * sin(180.0 * rise + 7.0 * azimuth);
    vec3 ground = vec3(0.29, 0.36, 0.13) + vec3(1.4, 0.8, 0.4) * patch_;
    return mix(ground, vec3(0.12 + leafy, 0.20 + leafy, 0.09), trees);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 ray = matrix * vec3(vec2(pixel), 1.0);
    int face = texelFetch(faces, pixel, 0).r;
    vec3 radiance = face < 0 ? sky(normalize(ray)) : surface(face, ray, pixel);
    radiance = max(radiance, vec3(0.0));
    vec3 over = max(radiance - 0.55, vec3(0.0));
    vec3 shown = min(radiance, vec3(0.55)) + over * 0.45 / (over + 0.45);
    vec3 curve = 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055;
    color = vec4(mix(12.92 * shown, curve, greaterThan(shown, vec3(0.0031308))), 1.0);
}
"""
