// SPDX-License-Identifier: Apache-2.0
// Connections of points with lights through panes. A ray is aimed at a point of the light, and
// aimed again by Newton's method, with the derivatives of its end by its direction, until it hits
// the point [Hanika et al. 2015, "Manifold next event estimation"].
#include "light/light_pane_ray.h"

// Rays that are aimed at a point. Flat panes take two: the first misses by the pane's shift.
enum { AIMS = 6 };
// A ray is accepted that misses by less than this fraction of the distance and twice the rounding
// of positions. A lamp may shadow itself within a thousandth of its distance.
static const float AIMED = 1e-6f;
// Curved glass may distort a bundle of rays, against that of a straight line, by a matrix that
// differs from unity by less than this: samples of focused light are noisy. With .9 and without a
// limit, direct light in the test scene bulb-lamp has 1.17 times the variance, with .25 a fortieth
// of the light in a bathroom is left to caustics.
static const float DISTORTED = 0.5f;

// A ray that is aimed at a point, and its end beside that point.
struct aimed_ray {
    struct pane_ray pane;
    float accepted;      // a miss that is
    struct frame frame;  // n: its first direction; the derivatives are those by this along u and v
    vec3 miss;           // of the end from the point, across the ray
};

// Whether the hit s is of the light itself, at the end of the ray, or so near to it as a ray that
// misses it meets a surface that it nearly grazes.
static bool is_end(const struct aimed_ray *aimed, const struct interaction *s,
                   const struct light_end *to) {
    if (s->light != (int32_t)to->light) return false;
    return v3_dist2(s->p, to->p) <= sqrf(10.0f * (v3_len(aimed->miss) + aimed->accepted));
}

// Follows the ray to its end. False if it is stopped before that.
static bool follow_to_end(struct aimed_ray *aimed, const struct light_end *to,
                          const struct interaction *first) {
    struct pane_ray *pane = &aimed->pane;
    struct interaction s;
    bool met = true;
    if (first)
        s = *first;
    else
        met = scene_intersect(pane->scene, &pane->ray, &s);
    for (;;) {
        const vec3 left = v3_sub(to->p, pane->ray.o);
        const float along = v3_dot(left, pane->ray.d);
        aimed->miss = v3_sub(v3_mul(pane->ray.d, along), left);
        if (light_pane_ray_is_outside(pane) && along > 0.0f &&
            (!met || s.t >= along || is_end(aimed, &s, to))) {
            light_pane_ray_advance(pane, along);
            return pane->crossed > 0;
        }
        if (!met || !light_pane_ray_pass(pane, &s)) return false;
        met = scene_intersect(pane->scene, &pane->ray, &s);
    }
}

// The derivatives of the end, across the ray.
static void end_derivatives(const struct aimed_ray *aimed, vec3 dp[2]) {
    const vec3 exit = aimed->pane.ray.d;
    for (int i = 0; i < 2; i++)
        dp[i] = v3_mad(aimed->pane.dp[i], -v3_dot(aimed->pane.dp[i], exit), exit);
}

// Corrects the direction by the miss. False if the derivatives do not allow it.
static bool aim_again(const struct aimed_ray *aimed, vec3 *d) {
    vec3 dp[2];
    end_derivatives(aimed, dp);
    const struct frame f = frame_from_normal(aimed->pane.ray.d);
    const float a = v3_dot(dp[0], f.u), b = v3_dot(dp[1], f.u), x = v3_dot(aimed->miss, f.u);
    const float c = v3_dot(dp[0], f.v), e = v3_dot(dp[1], f.v), y = v3_dot(aimed->miss, f.v);
    const float det = a * e - b * c, u = (b * y - e * x) / det, v = (c * x - a * y) / det;
    if (!(u * u + v * v < 0.1f)) return false;
    *d = v3_unit(v3_mad(v3_mad(*d, u, aimed->frame.u), v, aimed->frame.v));
    return true;
}

// Whether curved glass leaves the bundle nearly as it would be without.
static bool is_faithful(const struct aimed_ray *aimed, const vec3 dp[2], float distance) {
    if (!aimed->pane.curved) return light_is_parallel(aimed->frame.n, aimed->pane.ray.d);
    const float s = 1.0f / distance;
    const vec3 a = v3_sub(v3_mul(dp[0], s), aimed->frame.u),
               b = v3_sub(v3_mul(dp[1], s), aimed->frame.v);
    return v3_len2(a) + v3_len2(b) < sqrf(DISTORTED);
}

bool light_connect(const struct satin_scene *scene, vec3 o, const struct light_end *to,
                   const struct interaction *first, struct light_connection *out) {
    const vec3 straight = v3_sub(to->p, o);
    const float distance = v3_len(straight);
    const float rounding = fmaxf(scene_rounding(scene, o), scene_rounding(scene, to->p));
    if (!(distance > 0.0f)) return false;
    vec3 d = v3_mul(straight, 1.0f / distance);
    for (int i = 0; i < AIMS; i++) {
        struct aimed_ray aimed = {.pane = light_pane_ray_begin(scene, o, d, PANES_MAX),
                                  .accepted = AIMED * distance + 2.0f * rounding,
                                  .frame = frame_from_normal(d)};
        aimed.pane.bundle = true;
        aimed.pane.dd[0] = aimed.frame.u;
        aimed.pane.dd[1] = aimed.frame.v;
        if (!follow_to_end(&aimed, to, i == 0 ? first : NULL)) return false;
        if (!(v3_len2(aimed.miss) <= sqrf(aimed.accepted))) {
            if (!aim_again(&aimed, &d)) return false;
            continue;
        }
        vec3 dp[2];
        end_derivatives(&aimed, dp);
        const float section = fabsf(v3_dot(v3_cross(dp[0], dp[1]), aimed.pane.ray.d));
        *out = (struct light_connection){.d = d,
                                         .exit = aimed.pane.ray.d,
                                         .T = aimed.pane.T,
                                         .crossed = aimed.pane.crossed,
                                         .spread = section / sqrf(distance)};
        return is_faithful(&aimed, dp, distance);
    }
    return false;
}

// The factor from the density of drawing a point q, with normal n, from p to that over the solid
// angle of the connection; 0 if its end faces away.
static float density_factor(const struct light_connection *connection, vec3 p, vec3 q, vec3 n) {
    if (v3_len2(n) == 0.0f) return connection->spread;
    const float cosine = -v3_dot(v3_unit(v3_sub(q, p)), n), at_exit = -v3_dot(connection->exit, n);
    return cosine > 0.0f && at_exit > 0.0f ? connection->spread * cosine / at_exit : 0.0f;
}

float light_connection_pdf(const struct satin_scene *scene, vec3 p,
                           const struct light_connection *connection,
                           const struct interaction *hit) {
    if (connection->crossed == 0) return light_pdf(scene, p, connection->d, hit);
    const float factor = density_factor(connection, p, hit->p, hit->ng);
    return factor * light_pdf(scene, p, v3_unit(v3_sub(hit->p, p)), hit);
}

// ---- Light samples ------------------------------------------------------------------------------

// Tests a light sample whose light is parallel.
static bool arrives_parallel(const struct satin_scene *scene, vec3 o, int panes,
                             struct interaction first, struct light_sample *s) {
    struct pane_ray ray = light_pane_ray_begin(scene, o, s->wi, panes);
    bool met;
    if (!light_pane_ray_continue(&ray, &first, &met) || ray.curved ||
        !light_is_parallel(s->wi, ray.ray.d))
        return false;
    if (isfinite(s->dist)) {  // a beam, which another of its points sends
        if (!met || first.light != (int32_t)s->light ||
            !light_sample_wi(scene, s->light, ray.ray.o, s->u, s->v, s))
            return false;
    } else if (met) {
        return false;
    }
    s->L = rgb_mul(s->L, ray.T);
    return true;
}

// Tests a light sample at a point.
static bool arrives_from_point(const struct satin_scene *scene, vec3 p, vec3 o, int panes,
                               const struct interaction *first, struct light_sample *s) {
    struct light_connection to;
    const struct light_end end = {s->p, s->light};
    if (!light_connect(scene, o, &end, first, &to) || to.crossed > panes) return false;
    const float factor = density_factor(&to, p, s->p, s->n);
    if (!(factor > 0.0f)) return false;
    // The intensity of a point of light is that along the last direction.
    const vec3 origin = v3_mad(s->p, -s->dist, to.exit);
    if (s->delta && !light_sample_wi(scene, s->light, origin, s->u, s->v, s)) return false;
    s->wi = to.d;
    s->L = rgb_mul(s->L, to.T);
    s->pdf_w *= factor;
    return true;
}

bool light_arrives(const struct satin_scene *scene, vec3 p, vec3 ng, int panes,
                   struct light_sample *s) {
    const struct ray ray = light_shadow_ray(scene, p, ng, s);
    if (!scene->panes || panes <= 0) return !scene_occluded(scene, &ray);
    struct interaction first;
    bool curved;
    if (!scene_intersect(scene, &ray, &first)) return true;
    if (!light_may_be_pane(scene, &first, v3_neg(ray.d), &curved)) return false;
    if (!isfinite(s->dist) || !light_is_local(&scene->light[s->light]))
        return arrives_parallel(scene, ray.o, panes, first, s);
    return arrives_from_point(scene, p, ray.o, panes, &first, s);
}
