"""Ordinary benches under a table camera, rendered by polygons: logs of a few strikes, with the rig file and the truth beside each.

Shares no code with `datasets/render` or `stages/track`: what is drawn is what polygons, OpenCV's filters and its JPEG make of a bench.
"""
import json
import pathlib
import struct
import sys

import cv2
import numpy as np
from mcap.writer import Writer

cv2.setNumThreads(1)
S = 6  # supersampling
T0 = 1_700_000_000

def lin(c):
    c = np.asarray(c, float) / 255
    return np.where(c <= .04045, c / 12.92, ((c + .055) / 1.055) ** 2.4)
LUT_N = 4096
POOL = np.random.default_rng(1).normal(size=6_000_000).astype(np.float32)
_x = np.arange(LUT_N + 1) / LUT_N
SRGB = (lambda v: v.astype(np.float32))(np.where(_x <= .0031308, _x * 12.92, 1.055 * _x ** (1 / 2.4) - .055) * 255)

class Cam:
    def __init__(s, w, h, f, pos, tilt=(0., 0.), dist=None):
        s.w, s.h, s.K = w, h, (f, f * 1.002, w / 2 + 4.3, h / 2 - 3.1)
        s.pos = np.array(pos, float); s.dist = dist or [0.] * 5
        a, b = np.radians(tilt)
        R = np.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1.]])  # rows right, down, forward
        ra = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
        rb = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
        s.R = ra @ rb @ R
    def quat(s):
        M = s.R.T  # columns are axes in table frame
        w = np.sqrt(max(0, 1 + M[0,0] + M[1,1] + M[2,2])) / 2
        x = np.sqrt(max(0, 1 + M[0,0] - M[1,1] - M[2,2])) / 2
        y = np.sqrt(max(0, 1 - M[0,0] + M[1,1] - M[2,2])) / 2
        z = np.sqrt(max(0, 1 - M[0,0] - M[1,1] + M[2,2])) / 2
        i = int(np.argmax([x, y, z, w]))
        if i == 0: return [x, (M[0,1]+M[1,0])/(4*x), (M[0,2]+M[2,0])/(4*x), (M[2,1]-M[1,2])/(4*x)]
        if i == 1: return [(M[0,1]+M[1,0])/(4*y), y, (M[1,2]+M[2,1])/(4*y), (M[0,2]-M[2,0])/(4*y)]
        if i == 2: return [(M[0,2]+M[2,0])/(4*z), (M[1,2]+M[2,1])/(4*z), z, (M[1,0]-M[0,1])/(4*z)]
        return [(M[2,1]-M[1,2])/(4*w), (M[0,2]-M[2,0])/(4*w), (M[1,0]-M[0,1])/(4*w), w]
    def project(s, P):
        q = (np.atleast_2d(P) - s.pos) @ s.R.T
        u, v = q[:, 0] / q[:, 2], q[:, 1] / q[:, 2]
        k1, k2, p1, p2, k3 = s.dist; r = u*u + v*v
        g = 1 + r*(k1 + r*(k2 + r*k3))
        du = u*g + 2*p1*u*v + p2*(r + 2*u*u); dv = v*g + p1*(r + 2*v*v) + 2*p2*u*v
        return np.stack([s.K[0]*du + s.K[2], s.K[1]*dv + s.K[3]], 1)
    def table(s, px, py):
        """Table points of pixels, by a fixed point for the lens."""
        x, y = (px - s.K[2]) / s.K[0], (py - s.K[3]) / s.K[1]; u, v = x.copy(), y.copy()
        k1, k2, p1, p2, k3 = s.dist
        for _ in range(12):
            r = u*u + v*v; g = 1 + r*(k1 + r*(k2 + r*k3))
            u = (x - 2*p1*u*v - p2*(r + 2*u*u)) / g; v = (y - p1*(r + 2*v*v) - 2*p2*u*v) / g
        d = u[..., None]*s.R[0] + v[..., None]*s.R[1] + s.R[2]
        t = -s.pos[2] / d[..., 2]
        return s.pos[0] + t*d[..., 0], s.pos[1] + t*d[..., 1]

def noise_tex(rng, x, y, scale, seed):
    r = np.random.default_rng(seed); n = r.normal(size=(256, 256)).astype(np.float32)
    n = cv2.GaussianBlur(n, (0, 0), 1.0); n /= n.std()
    return cv2.remap(n, ((x/scale) % 255).astype(np.float32), ((y/scale) % 255).astype(np.float32), cv2.INTER_LINEAR)

def ground(kind, x, y):
    base = {"grey": (150,150,146), "wood": (176,140,100), "oak": (196,160,116), "cloth": (96,108,120), "white": (225,226,222), "dark": (58,58,62), "green": (110,140,112)}[kind]
    c = np.broadcast_to(lin(base), x.shape + (3,)).copy()
    if kind in ("wood", "oak"):
        g = noise_tex(None, x*0.12, y, .006 if kind == "wood" else .004, 5)*.10 + noise_tex(None, x*.05, y, .02, 7)*.10
        c *= (1 + (1.7 if kind == "oak" else 1)*g)[..., None]
        c[..., 2] *= 1 - .1*np.tanh(g*5)
        seam = np.abs(((y + .03) % .14) - .07) < .0015
        if kind == "wood": c[seam] *= .5
    elif kind == "cloth":
        w = np.sin(x*2*np.pi/.004)*np.sin(y*2*np.pi/.004)
        c *= (1 + .10*w + .05*noise_tex(None, x, y, .003, 9))[..., None]
    else:
        c *= (1 + .015*noise_tex(None, x, y, .01, 3))[..., None]
    return np.clip(c, .001, 1)

def polyfill(mask, pts, off):
    p = (np.asarray(pts) - off + .5) * S - .5
    cv2.fillPoly(mask, [np.round(p*256).astype(np.int32)], 1.0, shift=8)

def hull(p): return cv2.convexHull(p.astype(np.float32))[:, 0]

class Scene:
    def __init__(s, **k):
        s.cam = k.get("cam") or Cam(640, 480, 500, (.50, .04, 1.2), (2, -3))
        s.kind = k.get("table", "grey"); s.shape = k.get("shape", "cylinder")
        s.colour = lin(k.get("colour", (196, 42, 46))); s.print = k.get("print")
        s.light = k.get("light", 1.0); s.grad = k.get("grad", (.1, -.12)); s.vig = k.get("vig", 0.)
        s.noise = k.get("noise", 2.0); s.jpeg = k.get("jpeg", 88); s.enc = k.get("enc", "jpeg")
        s.blur = k.get("blur", .55); s.sharp = k.get("sharp", 0.); s.curve = k.get("curve", 0.)
        s.exposure = k.get("exposure", .005); s.readout = k.get("readout", 0.)
        s.told = k.get("told", True); s.shadow = k.get("shadow", (.35, 3.)); s.height = k.get("height", .04)
        s.told_height = k.get("told_height", s.height); s.lines = k.get("lines", False)
        s.extra = k.get("extra", ()); s.hide = k.get("hide"); s.push = k.get("push"); s.rate = k.get("rate", 30.)
        s.arm = k.get("arm", True); s.wb = np.array(k.get("wb", (1, 1, 1.))); s.drift = k.get("drift", 0.)
        s.rect = k.get("rect", False); s.before = k.get("before", False); s.mode = k.get("mode"); s.hue = k.get("hue", (340., 20.)); s.r = k.get("r", .03); s.sat = k.get("sat", .4)
        s.half = (.03, .03); s.strikes = k.get("strikes", 2); s.mark = k.get("mark"); s.plain = k.get("plain", False); s.spill = k.get("spill", 0.); s.sides = k.get("sides", (.75, .4)); s.tip = k.get("tip", True)
        s.hand = k.get("hand", False); s.glare = k.get("glare", False)
        w, h = s.cam.w, s.cam.h
        acc = 0
        for i in range(3):
            for j in range(3):
                px, py = np.meshgrid(np.arange(w) + (i-1)/3, np.arange(h) + (j-1)/3)
                x, y = s.cam.table(px, py); c = ground(s.kind, x, y)
                if s.lines:
                    for a in (.30, .55, .80): c[np.abs(x - a) < .012] = lin((238, 236, 225))
                    c[np.abs(y - .12) < .012] = lin((30, 30, 34))
                if "cable" in s.extra:
                    yy = .33 + .05*np.sin(x*6); c[np.abs(y - yy) < .003] = lin((190, 38, 40))
                if "cable_near" in s.extra:
                    yy = .24 + .03*np.sin(x*9); c[np.abs(y - yy) < .002] = lin((200, 40, 40))
                if "mug" in s.extra: c[(x - .95)**2 + (y + .45)**2 < .04**2] = lin((185, 35, 30))
                if "tape" in s.extra: c[(np.abs(x - .9) < .05) & (np.abs(y - .30) < .009)] = lin((200, 40, 45))
                if "border" in s.extra: c[(x > 1.0)] = lin((180, 40, 35))
                if "checker" in s.extra:
                    m = (np.floor(x/.05) + np.floor(y/.05)) % 2 == 0; c[m] *= .35
                if "book" in s.extra: c[(np.abs(x - .35) < .10) & (np.abs(y + .34) < .07)] = lin((60, 90, 170))
                acc = acc + c
        s.bg = (acc/9).astype(np.float32)
        px, py = np.meshgrid(np.arange(w), np.arange(h)); x, y = s.cam.table(px.astype(float), py.astype(float))
        s.shade = (s.light*(1 + s.grad[0]*(x - .5) + s.grad[1]*y)).astype(np.float32)
        r = np.hypot((px - w/2)/(w/2), (py - h/2)/(w/2)); s.shade *= (1 - s.vig*r*r)
    def body(s, x, y, yaw, delay):
        """Layers of the object at a pose: (polygons in px, colour), bottom up."""
        h, r = s.height, s.r; out = []; cam = s.cam
        to = s.light_dir = np.array([np.cos(2.0), np.sin(2.0)])
        if s.shape == "box":
            c, q = np.cos(yaw), np.sin(yaw); cor = []
            for a, b in ((1,1),(-1,1),(-1,-1),(1,-1)):
                cor.append([c*a*s.half[0] - q*b*s.half[1], q*a*s.half[0] + c*b*s.half[1]])
            ring = np.array(cor)
        else:
            a = np.linspace(0, 2*np.pi, 97)[:-1]; ring = r*np.stack([np.cos(a), np.sin(a)], 1)
        if s.shape == "sphere":
            to3 = cam.pos - np.array([x, y, r]); d = np.linalg.norm(to3); n = to3/d; sh = r/d
            e1 = np.cross(n, [0, 0, 1.]); e1 /= max(np.linalg.norm(e1), 1e-9)
            if np.linalg.norm(np.cross(n, [0,0,1.])) < 1e-6: e1 = np.array([1., 0, 0])
            e2 = np.cross(n, e1); a = np.linspace(0, 2*np.pi, 97)[:-1]
            for k in range(12):  # rings, shaded by how far they face up
                rho = np.cos(k/12*np.pi/2*.999)
                z = np.sqrt(max(0, 1 - rho*rho))
                rr = r*rho*np.sqrt(1 - sh*sh); ax = r*(sh + (1 - sh)*z)
                P = np.array([x, y, r]) + ax*n + rr*(np.cos(a)[:, None]*e1 + np.sin(a)[:, None]*e2)
                out.append((cam.project(P), s.colour*(.55 + .45*z)))
            return out
        bot = np.c_[ring + [x, y], np.zeros(len(ring))]; top = np.c_[ring + [x, y], np.full(len(ring), h)]
        n = len(ring); pb, pt = cam.project(bot), cam.project(top)
        out.append((hull(np.r_[pb, pt]), s.colour*s.sides[1]))
        for k in range(n):
            m = (k + 1) % n; mid = ring[k] + ring[m]; mid = mid/np.linalg.norm(mid)
            if np.dot(np.append(mid, 0), cam.pos - bot[k]) <= 0: continue
            lit = s.sides[1] + (s.sides[0] - s.sides[1])*.5*(1 + mid@to)
            col = s.colour
            if s.print == "half" and (np.cos(yaw)*ring[k][1] - np.sin(yaw)*ring[k][0]) > 0: col = lin((40, 80, 180))
            if s.print == "halfwhite" and (np.cos(yaw)*ring[k][1] - np.sin(yaw)*ring[k][0]) > 0: col = lin((235, 235, 230))
            out.append((np.array([pb[k], pb[m], pt[m], pt[k]]), col*lit))
        out.append((pt, s.colour))
        def face(pts, colour):
            p = np.asarray(pts, float); c, q = np.cos(yaw), np.sin(yaw)
            w = np.c_[x + c*p[:, 0] - q*p[:, 1], y + q*p[:, 0] + c*p[:, 1], np.full(len(p), h)]
            out.append((cam.project(w), lin(colour)))
        sq = lambda a, ox=0, oy=0: [(ox-a, oy-a), (ox+a, oy-a), (ox+a, oy+a), (ox-a, oy+a)]
        pr = s.print
        if s.mark:  # as OpenCV draws it, upright where the object's y is up
            bits, size = mark_bits(s.mark), s.mark["size"]; cells = len(bits); a = size/cells; ox, oy = s.mark.get("offset", (0., 0.)); my = s.mark.get("yaw", 0.)
            def put(l, t, r, b, colour):
                c, q = np.cos(my), np.sin(my); w = [((l - cells/2)*a, (cells/2 - t)*a), ((r - cells/2)*a, (cells/2 - t)*a), ((r - cells/2)*a, (cells/2 - b)*a), ((l - cells/2)*a, (cells/2 - b)*a)]
                face([(ox + c*p - q*r_, oy + q*p + c*r_) for p, r_ in w], colour)
            g = s.mark.get("margin", 1.); put(-g, -g, cells + g, cells + g, (240, 240, 238)); put(0, 0, cells, cells, (24, 24, 26))
            for i in range(cells):
                j = 0
                while j < cells:
                    k = j
                    while k < cells and bits[i, k]: k += 1
                    if k > j: put(j, i, k, i + 1, (240, 240, 238))
                    j = max(k, j + 1)
            if s.spill:  # a finger's width over one corner
                face([(ox + size*.5, oy + size*.5), (ox + size*.5 - s.spill, oy + size*.5), (ox + size*.5 - s.spill, oy + size*.5 - s.spill), (ox + size*.5, oy + size*.5 - s.spill)], (150, 120, 105))
        if pr == "label":  # 29 % of the face
            face(sq(.0143), (240, 240, 236)); face([(-.012, -.002), (.012, -.002), (.012, .002), (-.012, .002)], (25, 25, 25))
        if pr == "square": face(sq(.01), (240, 240, 236))
        if pr == "square22": face(sq(.0125, .006, .004), (240, 240, 236))
        if pr == "tag":
            face(sq(.018), (240, 240, 240)); face(sq(.0144), (20, 20, 20))
            for i, j in ((0, 1), (1, 2), (2, 0), (3, 3), (1, 1), (2, 3), (3, 0)):
                face(sq(.0024, -.0072 + .0048*i, -.0072 + .0048*j), (240, 240, 240))
        if pr in ("half", "halfwhite"):
            a = np.linspace(0, np.pi, 40); face(np.c_[.03*np.cos(a), .03*np.sin(a)], (40, 80, 180) if pr == "half" else (235, 235, 230))
        if pr == "cross":
            face([(-.029,-.002),(.029,-.002),(.029,.002),(-.029,.002)], (20,20,20)); face([(-.002,-.029),(.002,-.029),(.002,.029),(-.002,.029)], (20,20,20))
        if pr == "bar": face([(.0, -.003), (.035, -.003), (.035, .003), (0, .003)], (30, 30, 30))
        if pr == "ring":
            a = np.linspace(0, 2*np.pi, 60); face(np.c_[.02*np.cos(a), .02*np.sin(a)], (235, 235, 230)); face(np.c_[.014*np.cos(a), .014*np.sin(a)], (196, 42, 46))
        if pr == "rim":  # a dark sticker that reaches the rim
            a = np.linspace(-.5, .5, 20); face(np.r_[np.c_[.03*np.cos(a), .03*np.sin(a)], np.c_[.012*np.cos(a[::-1]), .012*np.sin(a[::-1])]], (28, 28, 30))
        return out
    def armlayers(s, tip, z, half, colour=(120, 122, 126)):
        if tip is None: return []
        ang = np.arctan2(tip[1], tip[0] + .25); d = np.array([np.cos(ang), np.sin(ang)]); n = np.array([-d[1], d[0]])
        a = np.linspace(-np.pi/2, np.pi/2, 20)
        c = np.array(tip) - d*half
        front = np.array([c + half*(np.cos(t)*d + np.sin(t)*n) for t in a])
        P = np.r_[front, [c + half*n - d*1.2], [c - half*n - d*1.2]]
        return [(s.cam.project(np.c_[P, np.full(len(P), z)]), lin(colour))]
    def tipball(s, tip):
        a = np.linspace(0, 2*np.pi, 48); P = np.c_[tip[0] + .012*np.cos(a), tip[1] + .012*np.sin(a), np.full(48, .03)]
        Q = P.copy(); Q[:, 2] = .012
        return [(hull(np.r_[s.cam.project(P), s.cam.project(Q)]), lin((70, 72, 76)))]
    def clean(s, pose, tip, cover, t, gain=1., shift=(0, 0)):
        """Linear image at the middle stamp t; pose(t), tip(t), cover(t) give places."""
        row0 = s.cam.project([[*pose(t)[:2], .0]])[0, 1]
        d = s.readout*row0/(s.cam.h - 1)
        moving = np.hypot(*(np.subtract(pose(t + d + .5*s.exposure)[:2], pose(t + d - .5*s.exposure)[:2]))) > 1e-6 or (s.arm and tip(t) is not None and np.hypot(*np.subtract(tip(t + .002), tip(t - .002))) > 1e-6)
        n = max(1, min(9, int(s.exposure*1.0*600*2))) if moving and s.exposure > 0 else 1
        img = None
        for k in range(n):
            tk = t + s.exposure*((k + .5)/n - .5)
            p = pose(tk + d); layers = []
            body = s.body(*p, 0)
            if s.readout:  # each corner at the time of its row
                v = np.subtract(pose(tk + d + 1e-4)[:2], pose(tk + d - 1e-4)[:2])/2e-4
                g = (s.cam.project([[p[0] + .005, p[1], .02]])[0] - s.cam.project([[p[0] - .005, p[1], .02]])[0])/.01
                hh = (s.cam.project([[p[0], p[1] + .005, .02]])[0] - s.cam.project([[p[0], p[1] - .005, .02]])[0])/.01
                vel = g*v[0] + hh*v[1]
                body = [(q + ((q[:, 1:2] - row0)*s.readout/(s.cam.h - 1))*vel, c) for q, c in body]
            sh = []
            if s.shadow[0] > 0:
                l = np.array([np.cos(2.0), np.sin(2.0)])*-.6*s.height; a = np.linspace(0, 2*np.pi, 60)
                ring = s.r*np.stack([np.cos(a), np.sin(a)], 1)*(1.0 if s.shape != "box" else 1.2)
                P = np.r_[ring + p[:2], ring + p[:2] + l]; hp = cv2.convexHull(P.astype(np.float32))[:, 0]
                sh = s.cam.project(np.c_[hp, np.zeros(len(hp))])
            over = []
            if s.arm:
                tp = tip(tk)
                if tp is not None:
                    over += s.tipball(tp) if s.tip else []
                    dd = np.array([np.cos(np.arctan2(tp[1], tp[0] + .25)), np.sin(np.arctan2(tp[1], tp[0] + .25))])
                    over += s.armlayers(np.array(tp) - dd*.008, .06, .016)
            cv = cover(tk)
            if cv is not None: over += s.armlayers(cv, .09, .03, (150, 150, 155))
            allp = np.concatenate([q for q, _ in body] + ([sh] if len(sh) else []) + [q for q, _ in over])
            lo = np.floor(np.clip(allp.min(0) - 4, 0, (s.cam.w - 1, s.cam.h - 1))).astype(int); hi = np.ceil(np.clip(allp.max(0) + 4, 1, (s.cam.w, s.cam.h))).astype(int)
            ob = np.concatenate([q for q, _ in body] + ([sh] if len(sh) else []))
            if img is None:
                img = (s.bg*s.shade[..., None]).astype(np.float32); accum = np.zeros_like(img) if n > 1 else None; base = img.copy()
            frame = base
            # arm outside the object's neighbourhood at 2x only: keep one ROI, but bounded
            olo = np.floor(np.clip(ob.min(0) - 6, 0, (s.cam.w - 1, s.cam.h - 1))).astype(int); ohi = np.ceil(np.clip(ob.max(0) + 6, 1, (s.cam.w, s.cam.h))).astype(int)
            frame = base.copy()
            if over:  # whole picture, plain antialiasing
                for q, c in over:
                    l = np.floor(np.clip(q.min(0) - 2, 0, (s.cam.w - 1, s.cam.h - 1))).astype(int); u = np.ceil(np.clip(q.max(0) + 2, 1, (s.cam.w, s.cam.h))).astype(int); sl = np.s_[l[1]:u[1], l[0]:u[0]]
                    m = np.zeros(frame.shape[:2], np.uint8)[sl].copy()
                    cv2.fillPoly(m, [np.round((q - l)*256).astype(np.int32)], 255, cv2.LINE_AA, shift=8)
                    a = (m*np.float32(1/255))[..., None]; frame[sl] = frame[sl]*(1 - a) + a*(c.astype(np.float32)*s.shade[sl][..., None])
            w, h = ohi - olo
            if w > 2 and h > 2:
                roi = cv2.resize(base[olo[1]:ohi[1], olo[0]:ohi[0]], (w*S, h*S), interpolation=cv2.INTER_LINEAR)
                if len(sh):
                    m = np.zeros((h*S, w*S), np.float32); polyfill(m, sh, olo); m = cv2.GaussianBlur(m, (0, 0), s.shadow[1]*S/2.4)
                    roi *= (1 - s.shadow[0]*m)[..., None]
                shd = float(s.shade[min(max(int(row0), 0), s.cam.h - 1), min(max(int(ob[:, 0].mean()), 0), s.cam.w - 1)])
                for q, c in body:
                    m = np.zeros((h*S, w*S), np.uint8); polyfill(m, q, olo); roi[m > 0] = (c*shd).astype(np.float32)
                if s.glare:
                    q = s.cam.project([[p[0] + .006, p[1] - .004, s.height]])[0]; yy, xx = np.mgrid[0:h*S, 0:w*S]
                    gl = 1.2*np.exp(-(((xx/S + olo[0]) - q[0])**2 + ((yy/S + olo[1]) - q[1])**2)/(2*2.2**2)); roi += gl[..., None].astype(np.float32)
                for q, c in over:
                    m = np.zeros((h*S, w*S), np.uint8); polyfill(m, q, olo); roi[m > 0] = (c*shd).astype(np.float32)
                frame[olo[1]:ohi[1], olo[0]:ohi[0]] = cv2.resize(roi, (w, h), interpolation=cv2.INTER_AREA)
            if n == 1: img = frame
            else: accum += frame/n
        if n > 1: img = accum
        if s.hand:
            m = np.zeros(img.shape[:2], np.uint8); q = s.cam.project([[.75, -.70, .03], [.72, -.42, .03], [.78, -.36, .03], [.84, -.40, .03], [.90, -.70, .03]])
            cv2.fillPoly(m, [np.round(q*256).astype(np.int32)], 255, cv2.LINE_AA, shift=8); a = (m/255.)[..., None]; img = (img*(1 - a) + a*lin((198, 148, 122))*s.light).astype(np.float32)
        return img
    def shoot(s, img, rng, gain=1., shift=(0, 0)):
        img = img*gain*s.wb
        if s.blur: img = cv2.GaussianBlur(img, (0, 0), s.blur)
        if any(shift): img = cv2.warpAffine(img.astype(np.float32), np.float32(turned(s.cam, *shift)), (s.cam.w, s.cam.h), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        b = SRGB[np.clip(img*LUT_N, 0, LUT_N).astype(int)]
        if s.curve: z = b/255; b = 255*(z + s.curve*(z - .5)*z*(1 - z)*4)
        if s.sharp: b = b + s.sharp*(b - cv2.GaussianBlur(b, (0, 0), 1.0))
        o = int(rng.integers(0, len(POOL) - b.size)); b = b + POOL[o:o + b.size].reshape(b.shape)*s.noise
        return np.clip(np.round(b), 0, 255).astype(np.uint8)
    def pack(s, b):
        if s.enc == "jpeg":
            ok, d = cv2.imencode(".jpg", b[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, s.jpeg]); return d.tobytes()
        if s.enc == "bayer":
            o = np.empty(b.shape[:2], np.uint8); o[0::2, 0::2] = b[0::2, 0::2, 0]; o[0::2, 1::2] = b[0::2, 1::2, 1]; o[1::2, 0::2] = b[1::2, 0::2, 1]; o[1::2, 1::2] = b[1::2, 1::2, 2]; return o.tobytes()
        return b.tobytes()

def turned(cam, x, y, degrees=0., zoom=1.):
    c, q = zoom*np.cos(np.radians(degrees)), zoom*np.sin(np.radians(degrees)); u, v = cam.w/2, cam.h/2
    return [[c, -q, x + u - c*u + q*v], [q, c, y + v - q*u - c*v]]

def cdr(parts):
    b = bytearray()
    for k, v in parts:
        if k == "u32": b += b"\0"*(-len(b) % 4) + struct.pack("<I", v)
        elif k == "u8": b += struct.pack("<B", v)
        elif k == "f64": b += b"\0"*(-len(b) % 8) + struct.pack("<d", v)
        elif k == "str": v = v.encode() + b"\0"; b += b"\0"*(-len(b) % 4) + struct.pack("<I", len(v)) + v
        else: b += b"\0"*(-len(b) % 4) + struct.pack("<I", len(v)) + v
    return b"\0\1\0\0" + bytes(b)

def mark_bits(mark):
    """A marker's cells with its border, white is 1, from OpenCV's own drawing."""
    book = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, mark["dictionary"])); n = book.markerSize + 2
    return cv2.aruco.generateImageMarker(book, mark["id"], n*8)[4::8, 4::8] > 127

RAW = [-.21, .06, .001, -.001, 0.]  # the lens that rectified images had before

def raw(cam): return [cam.K[0]*1.03, cam.K[1]*1.03, cam.K[2] - 5, cam.K[3] + 4]

def rig_toml(s, info=False):
    c = s.cam; K, D = (raw(c), RAW) if s.before else (list(c.K), list(c.dist)); o = {"cylinder": f'radius = {s.r}\nhalf_height = {s.told_height/2}', "box": f'half_size = [{s.half[0]}, {s.half[1]}, {s.told_height/2}]', "sphere": f'radius = {s.r}'}[s.shape]
    time = f"exposure = {s.exposure}\nreadout = {s.readout}\n" if s.told else ""
    cam = "" if info else f"matrix = {K}\nsize = [{c.w}, {c.h}]\ndistortion = {D}\n"
    seen = "" if s.plain else f"colour = {{ hue = [{s.hue[0]}, {s.hue[1]}], saturation = [{s.sat}, 1.0], value = [0.13, 1.0] }}\n"
    if m := s.mark and {"offset": (0., 0.), "yaw": 0., **s.mark}:
        seen += f'marker = {{ dictionary = "{m["dictionary"]}", id = {m.get("told_id", m["id"])}, size = {m.get("told", m["size"])}, offset = {list(m["offset"])}, yaw = {m["yaw"]} }}\n'
    return f"""[object]
shape = "{s.shape}"
{o}
mass = 0.1
{seen}[striker]
tip = "sphere"
radius = 0.012
[table]
x = [0.10, 1.00]
y = [-0.60, 0.60]
[camera]
rate = {s.rate}
noise = 0.0007
centre = [0.5, 0.0]
{cam}position = {[float(v) for v in c.pos]}
orientation = {[float(v) for v in c.quat()]}
{time}[robot]
speed = [0.4, 1.0]
angle = [-0.80, 0.80]
acceleration = 5.0
[topics.image]
name = "{'/camera/image_rect/compressed' if s.rect else '/camera/image'}"
"""

def strikes_of(s, rng):
    """Per strike: start, angle, speed, deceleration."""
    out = []
    for k in range(s.strikes):
        a = rng.uniform(-.5, .5); v = rng.uniform(.55, .85)
        out.append(dict(x=rng.uniform(.28, .42), y=rng.uniform(-.2, .2), a=a, v=v, g=rng.uniform(1.8, 2.4), yaw=rng.uniform(-.6, .6), w=rng.uniform(-2, 2)))
    return out

def write(s, name, folder, seed):
    rng = np.random.default_rng(seed); folder = pathlib.Path(folder)/name; folder.mkdir(parents=True, exist_ok=True)
    (folder/"rig.toml").write_text(rig_toml(s, s.rect and not s.before))
    truth = []; f = open(folder/"log.mcap", "wb"); w = Writer(f); w.start()
    rawk = s.enc != "jpeg"; schema = "sensor_msgs/msg/Image" if rawk else "sensor_msgs/msg/CompressedImage"
    sid = w.register_schema(schema, "ros2msg", b""); topic = "/camera/image_rect/compressed" if s.rect else "/camera/image"
    ch = w.register_channel(topic, "cdr", sid)
    jid = w.register_schema("geometry_msgs/msg/TwistStamped", "jsonschema", b"{}"); cc = w.register_channel("/striker/command", "json", jid)
    if s.rect:
        iid = w.register_schema("sensor_msgs/msg/CameraInfo", "ros2msg", b""); ic = w.register_channel("/camera/camera_info", "cdr", iid)
        K = s.cam.K; r = raw(s.cam); kk = [r[0], 0, r[2], 0, r[1], r[3], 0, 0, 1]; P = [K[0], 0, K[2], 0, 0, K[1], K[3], 0, 0, 0, 1, 0]
        m = [("u32", T0), ("u32", 0), ("str", "camera"), ("u32", s.cam.h), ("u32", s.cam.w), ("str", "plumb_bob"), ("u32", 5)] + [("f64", v) for v in RAW] + [("f64", v) for v in kk] + [("f64", v) for v in (1, 0, 0, 0, 1, 0, 0, 0, 1)] + [("f64", v) for v in P]
        m += [("u32", 0), ("u32", 0), ("u32", 0), ("u32", 0), ("u32", 0), ("u32", 0), ("u8", 0)]
        w.add_message(ic, T0*10**9, cdr(m), T0*10**9)
    t = 0.; per = 1/s.rate; n = 0; pending = []
    for k, st in enumerate(strikes_of(s, rng)):
        t_imp = t + .75 + rng.uniform(0, per); T = st["v"]/st["g"]; dirn = np.array([np.cos(st["a"]), np.sin(st["a"])])
        def pose(tt, st=st, t_imp=t_imp, T=T, dirn=dirn):
            u = min(max(tt - t_imp, 0), T); d = st["v"]*u - .5*st["g"]*u*u; yw = st["yaw"] + st["w"]*(u - .5*u*u/T)
            return st["x"] + d*dirn[0], st["y"] + d*dirn[1], yw
        reach = s.r + .012
        def tip(tt, st=st, t_imp=t_imp, dirn=dirn, reach=reach):
            # comes 0.12 m at the object's speed less a tenth, stops 2 cm behind the impact, goes back 0.25 s later
            u = tt - t_imp; v = .85*st["v"]
            if u < -.25: q = -.2125*st["v"]
            elif u < .03: q = v*u
            elif u < .25: q = v*.03
            else: q = max(-.12, v*.03 - .4*(u - .25))
            return np.array([st["x"], st["y"]]) + dirn*(q - reach)
        def cover(tt, st=st, t_imp=t_imp, pose=pose):
            if s.hide is None: return None
            u = tt - t_imp; h = 2*per
            if -h <= u <= h:
                p = np.array(pose(tt)[:2]); return p + np.array([s.hide, 0])
            return np.array([st["x"] - .16, st["y"]])
        end = t_imp + T + .75; cache = None
        # command: trapezoid in JSON at 200 Hz, ends at the impact
        tc = t_imp - .16
        while tc < t_imp + .02:
            u = (tc - (t_imp - .16)); sp = min(st["v"]*.85, 5*u) if tc < t_imp else max(0., st["v"]*.85 - 20*(tc - t_imp))
            pending.append((tc, json.dumps({"header": {"stamp": {"sec": int(T0 + tc), "nanosec": int((T0 % 1 + tc % 1)*1e9)}, "frame_id": "table"}, "twist": {"linear": {"x": sp*dirn[0], "y": sp*dirn[1], "z": 0.}, "angular": {"x": 0., "y": 0., "z": 0.}}}).encode())); tc += .005
        pending.append((tc, json.dumps({"header": {"stamp": {"sec": int(T0 + tc), "nanosec": int((tc % 1)*1e9)}, "frame_id": "table"}, "twist": {"linear": {"x": 0., "y": 0., "z": 0.}, "angular": {"x": 0., "y": 0., "z": 0.}}}).encode()))
        while t < end:
            still = (pose(t - .05)[0] == pose(t + .05)[0]) and np.allclose(tip(t - .05), tip(t + .05)) and (s.hide is None or abs(t - t_imp) > .2)
            if not (still and cache is not None):
                cache_img = s.clean(pose, tip, cover, t); cache = cache_img if still else None
            gain = 1 + s.drift*np.sin(t*.9); shift = s.push[1] if s.push and (k, t) >= (s.push[0], t_imp + s.push[2]) else (0, 0)
            b = s.shoot(cache_img, rng, gain, shift); data = s.pack(b)
            stamp = T0*10**9 + int(round(t*1e9))
            while pending and pending[0][0] <= t:
                tc, d = pending.pop(0); tcn = T0*10**9 + int(tc*1e9); w.add_message(cc, tcn, d, tcn)
            sec, ns = divmod(stamp, 10**9)
            if rawk: m = cdr([("u32", sec), ("u32", ns), ("str", "c"), ("u32", s.cam.h), ("u32", s.cam.w), ("str", "bayer_rggb8" if s.enc == "bayer" else "rgb8"), ("u8", 0), ("u32", s.cam.w*(1 if s.enc == "bayer" else 3)), ("bytes", data)])
            else: m = cdr([("u32", sec), ("u32", ns), ("str", "c"), ("str", "jpeg"), ("bytes", data)])
            w.add_message(ch, stamp, m, stamp)
            # truth at the middle of the exposure of the rows of the object
            row = s.cam.project([[*pose(t)[:2], .02]])[0, 1]; d = s.readout*row/(s.cam.h - 1)
            truth.append(dict(stamp=stamp, delay=d, strike=k, at=list(map(float, pose(t + d))), speed=float(max(0, st["v"] - st["g"]*max(0, t + d - t_imp)) if t + d > t_imp else 0), hidden=bool(s.hide is not None and abs(t - t_imp) <= 2*per)))
            if n in (3, 30): cv2.imwrite(str(folder/f"shot{n}.png"), b[..., ::-1])
            n += 1; t += per
        t += .6
    w.finish(); f.close()
    (folder/"truth.json").write_text(json.dumps(dict(frames=truth, strikes=s.strikes)))
    return n

C = Cam
SCENES = {
 "clean": dict(), "wood": dict(table="wood"), "oak_curve": dict(table="oak", curve=.9), "cloth": dict(table="cloth"), "white": dict(table="white", light=.8),
 "dark": dict(table="dark"), "tape_lines": dict(lines=True), "wood_lines": dict(table="wood", lines=True), "checker": dict(extra=("checker",)),
 "label": dict(print="label"), "tag": dict(print="tag"), "half": dict(print="half"), "halfwhite": dict(print="halfwhite"), "square": dict(print="square"),
 "square22": dict(print="square22"), "cross": dict(print="cross"), "ring": dict(print="ring"), "rim": dict(print="rim"), "bar": dict(print="bar"),
 "hide_half": dict(hide=-.0), "hide_quarter": dict(hide=-.015), "cable": dict(extra=("cable",)), "cable_near": dict(extra=("cable_near",)), "mug": dict(extra=("mug",)),
 "red_tape": dict(extra=("tape",)), "red_border": dict(extra=("border",)), "book": dict(extra=("book",)),
 "jpeg50": dict(jpeg=50), "jpeg77": dict(jpeg=77), "mm35": dict(cam=C(440, 330, 343, (.5, .04, 1.2), (2, -3))), "mm44": dict(cam=C(352, 264, 273, (.5, .04, 1.2), (2, -3))),
 "mm35_wood_jpeg": dict(cam=C(440, 330, 343, (.5, .04, 1.2), (2, -3)), table="wood", jpeg=75),
 "exp10": dict(exposure=.010), "exp16": dict(exposure=.016), "readout20": dict(readout=.020), "bayer": dict(enc="bayer"), "rgb": dict(enc="rgb"),
 "vignette": dict(vig=.5), "noise6": dict(noise=6.), "hard_shadow": dict(shadow=(.75, .5)), "underexposed": dict(light=.22), "warm": dict(wb=(1.25, 1., .7)),
 "box": dict(shape="box"), "sphere": dict(shape="sphere", r=.025), "box_label": dict(shape="box", print="label"), "blue_wood": dict(colour=(38, 70, 180), hue=(200., 250.), table="wood"),
 "green_cloth": dict(colour=(40, 150, 60), hue=(100., 160.), table="cloth"), "tilt25": dict(cam=C(640, 480, 470, (.15, .04, 1.15), (0, 20))), "lens": dict(cam=C(640, 480, 520, (.5, .04, 1.2), (2, -3), [-.22, .07, .001, -.0008, 0.])),
 "p720": dict(cam=C(1280, 720, 1000, (.5, .04, 1.2), (2, -3)), strikes=3), "defocus": dict(blur=1.5), "sharpened": dict(sharp=1.2), "auto_exposure": dict(drift=.25), "hand": dict(hand=True),
 "smooth_dark": dict(table="dark", colour=(225, 190, 40), hue=(35., 65.)), "glare": dict(glare=True), "low_wood_jpeg60": dict(table="wood", jpeg=60, noise=4.), "orange_oak": dict(table="oak", colour=(235, 95, 20), hue=(5., 30.), sat=.65), "all": dict(table="wood", lines=True, print="label", extra=("cable",), jpeg=75, vig=.3, noise=3.),
}
WRONG = {"untold_readout": dict(readout=.020, told=False), "untold_exposure": dict(exposure=.033, told=False), "pushed": dict(push=(1, (1.5, -1.4), -1.)), "pushed_wood": dict(push=(1, (2.0, 0.), -1.), table="wood"), "pushed_early": dict(push=(0, (2., 1.4), -.5), table="wood"),
 "pushed_between": dict(push=(0, (1.6, 1.2), .3)), "pushed_far": dict(push=(1, (10., 6.), -1.)), "pushed_farther": dict(push=(1, (25., -14.), -1.), table="wood"), "turned": dict(push=(1, (0., 0., 1.), -1.), table="wood"), "zoomed": dict(push=(1, (1., -.5, 0., 1.012), -1.), table="wood"),
 "rectified": dict(rect=True), "rectified_lens_of_before": dict(rect=True, before=True), "height30": dict(told_height=.03), "height50": dict(told_height=.05)}

TAG = dict(dictionary="DICT_APRILTAG_36h11", id=7, size=.032)
HD = C(1280, 720, 1000, (.5, .04, 1.2), (2, -3))
MARKED = {
 "tag36h11": dict(mark=TAG, cam=HD), "aruco4x4": dict(mark=dict(dictionary="DICT_4X4_50", id=3, size=.034), cam=HD), "aruco5x5": dict(mark=dict(dictionary="DICT_5X5_100", id=42, size=.034), cam=HD),
 "aruco6x6_wood": dict(mark=dict(dictionary="DICT_6X6_250", id=100, size=.034), cam=HD, table="wood"), "aruco7x7": dict(mark=dict(dictionary="DICT_7X7_1000", id=815, size=.034), cam=HD),
 "tag16h5": dict(mark=dict(dictionary="DICT_APRILTAG_16h5", id=11, size=.034), cam=HD),
 "tag_box": dict(mark={**TAG, "offset": (.004, -.003), "yaw": 1.2}, cam=HD, shape="box"), "tag_white_no_colour": dict(mark=TAG, cam=HD, colour=(205, 205, 200), plain=True, table="wood"),
 "tag_lens": dict(mark=TAG, cam=C(1280, 720, 1040, (.5, .04, 1.2), (2, -3), [-.22, .07, .001, -.0008, 0.])), "tag_tilt25": dict(mark=TAG, cam=C(1280, 720, 940, (.15, .04, 1.15), (0, 20))),
 "tag_exp10": dict(mark=TAG, cam=HD, exposure=.010), "tag_exp16": dict(mark=TAG, cam=HD, exposure=.016), "tag_readout20": dict(mark=TAG, cam=HD, readout=.020),
 "tag_jpeg50": dict(mark=TAG, cam=HD, jpeg=50), "tag_noise6": dict(mark=TAG, cam=HD, noise=6.), "tag_dim": dict(mark=TAG, cam=HD, light=.22), "tag_bright": dict(mark=TAG, cam=HD, light=1.35),
 "tag_defocus": dict(mark=TAG, cam=HD, blur=1.5), "tag_sharpened": dict(mark=TAG, cam=HD, sharp=1.2), "tag_hard_shadow": dict(mark=TAG, cam=HD, shadow=(.75, .5), vig=.5), "tag_glare": dict(mark=TAG, cam=HD, glare=True),
 "tag_hide_half": dict(mark=TAG, cam=HD, hide=0.), "tag_hide_quarter": dict(mark=TAG, cam=HD, hide=-.015), "tag_corner_hidden": dict(mark=TAG, cam=HD, spill=.007), "tag_no_margin": dict(mark={**TAG, "margin": .5}, cam=HD),
 "tag_pushed": dict(mark=TAG, cam=HD, push=(1, (3., -2.), -1.), table="wood"), "tag480": dict(mark={**TAG, "size": .036}), "aruco4x4_480": dict(mark=dict(dictionary="DICT_4X4_50", id=3, size=.036)), "aruco4x4_480_jpeg": dict(mark=dict(dictionary="DICT_4X4_50", id=3, size=.036), jpeg=75, table="wood", exposure=.010),
 "tag_other_id": dict(mark={**TAG, "told_id": 8}, cam=HD, plain=True),
}

def main():
    """Writes the logs of all benches that are not there yet: FOLDER SEED STRIKES [NAMES]; of those with markers where they are named, or all where `marked` is."""
    folder, seed, strikes, only = pathlib.Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:]
    frames = {}
    for number, (name, words) in enumerate({**SCENES, **WRONG, **MARKED}.items()):
        if name in MARKED if not only else name not in (MARKED if only == ["marked"] else only):
            continue
        if not (folder / name / "truth.json").exists():
            write(Scene(**{**words, "strikes": strikes}), name, folder, seed * 1000 + number)
        frames[name] = len(json.loads((folder / name / "truth.json").read_text())["frames"])
    print(json.dumps({"ordinary": [name for name in frames if name in SCENES], "told": [name for name in frames if name in WRONG], "marked": [name for name in frames if name in MARKED], "frames": frames}))


main()
