// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "vtk/egl_context.hpp"
#include <cstdlib>
#include <cstring>
#if !defined(_WIN32)
#include <dlfcn.h>
#endif

namespace cv { namespace surgtrack {

#if defined(_WIN32)   // VTK's own window is always there; nothing to be found out

struct EGLContextHolder::Library {};
EGLContextHolder::EGLContextHolder(const Ptr<Library>&, void*, void*) : display_(0), context_(0) {}
EGLContextHolder::~EGLContextHolder() {}
Ptr<EGLContextHolder> EGLContextHolder::create(String& reason) { reason = "EGL is not used on this system"; return Ptr<EGLContextHolder>(); }
bool EGLContextHolder::makeCurrent() const { return false; }
bool EGLContextHolder::isCurrent() const { return false; }
SavedGLContexts::SavedGLContexts() {}
SavedGLContexts::~SavedGLContexts() {}
XDisplayHolder::~XDisplayHolder() {}
XDisplayHolder::ErrorsIgnored::ErrorsIgnored() : was_(0) {}
XDisplayHolder::ErrorsIgnored::~ErrorsIgnored() {}
Ptr<XDisplayHolder> XDisplayHolder::create(String&) { return Ptr<XDisplayHolder>(new XDisplayHolder(0, 0)); }

#else

// Numbers from the registries of EGL, OpenGL and GLX: the module is built without their headers.
enum
{
    EGL_NONE = 0x3038, EGL_VENDOR_EXTENSIONS = 0x3055, EGL_DRAW = 0x3059, EGL_READ = 0x305A,
    EGL_SURFACE_TYPE = 0x3033, EGL_PBUFFER_BIT = 1, EGL_RENDERABLE_TYPE = 0x3040, EGL_OPENGL_BIT = 8,
    EGL_OPENGL_API = 0x30A2, EGL_CONTEXT_MAJOR = 0x3098, EGL_CONTEXT_MINOR = 0x30FB, EGL_CONTEXT_PROFILE = 0x30FD, EGL_CORE_PROFILE = 1,
    EGL_PLATFORM_DEVICE = 0x313F, EGL_PLATFORM_SURFACELESS = 0x31DD, GL_VERSION_NAME = 0x1F02,
    GLX_RED_SIZE = 8, GLX_GREEN_SIZE = 9, GLX_BLUE_SIZE = 10, GLX_DEPTH_SIZE = 12
};

template <typename F> static bool load(F& function, void* library, const char* name)
{
    void* symbol = library ? dlsym(library, name) : 0;
    std::memcpy(&function, &symbol, sizeof(symbol));   // the cast from void* to a function is only conditionally supported
    return symbol != 0;
}

struct EGLContextHolder::Library
{
    typedef void (*Function)();
    Function (*getProcAddress)(const char*);
    const char* (*queryString)(void*, int);
    unsigned (*initialize)(void*, int*, int*);
    unsigned (*bindAPI)(unsigned);
    unsigned (*chooseConfig)(void*, const int*, void**, int, int*);
    void* (*createContext)(void*, void*, void*, const int*);
    unsigned (*destroyContext)(void*, void*);
    unsigned (*makeCurrent)(void*, void*, void*, void*);
    void* (*getCurrentContext)();
    void* (*getPlatformDisplay)(unsigned, void*, const int*);         // the two are extensions
    unsigned (*queryDevices)(int, void**, int*);

    bool open()
    {
        // Never closed: drivers do not survive being unloaded.
        void* library = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL);
        if (!load(getProcAddress, library, "eglGetProcAddress") || !load(queryString, library, "eglQueryString")
            || !load(initialize, library, "eglInitialize") || !load(bindAPI, library, "eglBindAPI")
            || !load(chooseConfig, library, "eglChooseConfig") || !load(createContext, library, "eglCreateContext")
            || !load(destroyContext, library, "eglDestroyContext") || !load(makeCurrent, library, "eglMakeCurrent")
            || !load(getCurrentContext, library, "eglGetCurrentContext"))
            return false;
        getPlatformDisplay = (void* (*)(unsigned, void*, const int*))getProcAddress("eglGetPlatformDisplayEXT");
        queryDevices = (unsigned (*)(int, void**, int*))getProcAddress("eglQueryDevicesEXT");
        return true;
    }

    bool has(void* display, const char* extension) const
    {
        const char* all = queryString(display, EGL_VENDOR_EXTENSIONS);
        return all && (String(" ") + all + " ").find(String(" ") + extension + " ") != String::npos;
    }
};

EGLContextHolder::EGLContextHolder(const Ptr<Library>& library, void* display, void* context)
    : egl_(library), display_(display), context_(context) {}

EGLContextHolder::~EGLContextHolder()
{
    // The display stays initialised: it is one for the whole process, and others may use it.
    if (isCurrent()) egl_->makeCurrent(display_, 0, 0, 0);
    egl_->destroyContext(display_, context_);
}

bool EGLContextHolder::makeCurrent() const
{
    return isCurrent() || (egl_->bindAPI(EGL_OPENGL_API) && egl_->makeCurrent(display_, 0, 0, context_));
}

bool EGLContextHolder::isCurrent() const
{
    return egl_->getCurrentContext() == context_;
}

Ptr<EGLContextHolder> EGLContextHolder::create(String& reason)
{
    const Ptr<Library> egl = makePtr<Library>();
    if (!egl->open())
    {
        reason = "libEGL.so.1 is not installed";
        return Ptr<EGLContextHolder>();
    }

    // Mesa's surfaceless platform, then every graphics device the vendors' drivers know.
    std::vector<std::pair<int, void*> > platforms;
    if (egl->getPlatformDisplay && egl->has(0, "EGL_MESA_platform_surfaceless")) platforms.push_back(std::make_pair(EGL_PLATFORM_SURFACELESS, (void*)0));
    if (egl->getPlatformDisplay && egl->queryDevices && egl->has(0, "EGL_EXT_platform_device"))
    {
        void* devices[16];
        int n = 0;
        if (!egl->queryDevices(16, devices, &n)) n = 0;
        for (int i = 0; i < n; i++) platforms.push_back(std::make_pair(EGL_PLATFORM_DEVICE, devices[i]));
    }
    reason = "libEGL has no driver that draws without a display (Debian: libegl-mesa0 and libgl1-mesa-dri)";

    for (size_t i = 0; i < platforms.size(); i++)
    {
        void* display = egl->getPlatformDisplay(platforms[i].first, platforms[i].second, 0);
        int major, minor, n = 0;
        if (!display || !egl->initialize(display, &major, &minor) || !egl->has(display, "EGL_KHR_surfaceless_context")) continue;
        const int wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
        const int version[] = {EGL_CONTEXT_MAJOR, 3, EGL_CONTEXT_MINOR, 2, EGL_CONTEXT_PROFILE, EGL_CORE_PROFILE, EGL_NONE};
        void* config = 0;
        if (!egl->bindAPI(EGL_OPENGL_API) || !egl->chooseConfig(display, wanted, &config, 1, &n) || n < 1) continue;
        void* context = egl->createContext(display, config, 0, version);
        if (!context)
        {
            reason = "the EGL driver has no OpenGL 3.2";
            continue;
        }
        const Ptr<EGLContextHolder> holder(new EGLContextHolder(egl, display, context));
        const unsigned char* (*getString)(unsigned) = (const unsigned char* (*)(unsigned))egl->getProcAddress("glGetString");
        if (holder->makeCurrent() && getString && getString(GL_VERSION_NAME)) return holder;
        reason = "the EGL context cannot be made current";
    }
    return Ptr<EGLContextHolder>();
}

SavedGLContexts::SavedGLContexts()
{
    // A library that nobody has loaded has no current context.
    std::memset(&glx_, 0, sizeof(glx_));
    std::memset(&egl_, 0, sizeof(egl_));
    void* glx = dlopen("libGLX.so.0", RTLD_LAZY | RTLD_NOLOAD);
    if (!glx) glx = dlopen("libGL.so.1", RTLD_LAZY | RTLD_NOLOAD);
    if (load(glx_.getCurrentContext, glx, "glXGetCurrentContext") && load(glx_.getCurrentDisplay, glx, "glXGetCurrentDisplay")
        && load(glx_.getCurrentDrawable, glx, "glXGetCurrentDrawable") && load(glx_.getCurrentReadDrawable, glx, "glXGetCurrentReadDrawable")
        && load(glx_.makeContextCurrent, glx, "glXMakeContextCurrent"))
    {
        glx_.context = glx_.getCurrentContext();
        glx_.display = glx_.getCurrentDisplay();
        glx_.draw = glx_.getCurrentDrawable();
        glx_.read = glx_.getCurrentReadDrawable();
    }
    else glx_.getCurrentContext = 0;

    void* egl = dlopen("libEGL.so.1", RTLD_LAZY | RTLD_NOLOAD);
    if (load(egl_.getCurrentContext, egl, "eglGetCurrentContext") && load(egl_.getCurrentDisplay, egl, "eglGetCurrentDisplay")
        && load(egl_.getCurrentSurface, egl, "eglGetCurrentSurface") && load(egl_.makeCurrent, egl, "eglMakeCurrent")
        && load(egl_.queryAPI, egl, "eglQueryAPI") && load(egl_.bindAPI, egl, "eglBindAPI"))
    {
        egl_.api = egl_.queryAPI();
        egl_.context = egl_.getCurrentContext();
        egl_.display = egl_.getCurrentDisplay();
        egl_.draw = egl_.getCurrentSurface(EGL_DRAW);
        egl_.read = egl_.getCurrentSurface(EGL_READ);
    }
    else egl_.getCurrentContext = 0;
    if (glx) dlclose(glx);
    if (egl) dlclose(egl);
    release();
}

void SavedGLContexts::release()
{
    if (egl_.getCurrentContext && egl_.getCurrentContext()) egl_.makeCurrent(egl_.getCurrentDisplay(), 0, 0, 0);
    if (glx_.getCurrentContext && glx_.getCurrentContext()) glx_.makeContextCurrent(glx_.getCurrentDisplay(), 0, 0, 0);
}

SavedGLContexts::~SavedGLContexts()
{
    release();
    if (glx_.context) glx_.makeContextCurrent(glx_.display, glx_.draw, glx_.read, glx_.context);
    if (egl_.getCurrentContext && egl_.api) egl_.bindAPI(egl_.api);
    if (egl_.context) egl_.makeCurrent(egl_.display, egl_.draw, egl_.read, egl_.context);
}

XDisplayHolder::~XDisplayHolder()
{
    close_(display);
}

static int ignoreError(void*, void*)
{
    return 0;
}

XDisplayHolder::ErrorsIgnored::ErrorsIgnored() : was_(0)
{
    void* (*setErrorHandler)(int (*)(void*, void*));
    if (load(setErrorHandler, dlopen("libX11.so.6", RTLD_LAZY | RTLD_LOCAL), "XSetErrorHandler")) was_ = setErrorHandler(ignoreError);
}

XDisplayHolder::ErrorsIgnored::~ErrorsIgnored()
{
    void* (*setErrorHandler)(void*);
    if (load(setErrorHandler, dlopen("libX11.so.6", RTLD_LAZY | RTLD_LOCAL), "XSetErrorHandler")) setErrorHandler(was_);
}

Ptr<XDisplayHolder> XDisplayHolder::create(String& reason)
{
    const char* name = std::getenv("DISPLAY");
    if (!name || !*name)
    {
        reason = "DISPLAY is not set";
        return Ptr<XDisplayHolder>();
    }
    void* (*openDisplay)(const char*);
    int (*closeDisplay)(void*);
    int (*queryExtension)(void*, const char*, int*, int*, int*);
    int (*defaultScreen)(void*);
    int (*release)(void*);
    void* x11 = dlopen("libX11.so.6", RTLD_LAZY | RTLD_LOCAL);
    if (!load(openDisplay, x11, "XOpenDisplay") || !load(closeDisplay, x11, "XCloseDisplay") || !load(queryExtension, x11, "XQueryExtension"))
    {
        reason = "libX11.so.6 is not installed";
        return Ptr<XDisplayHolder>();
    }
    void* display = openDisplay(name);
    if (!display)
    {
        reason = format("no X server answers at DISPLAY %s", name);
        return Ptr<XDisplayHolder>();
    }
    const Ptr<XDisplayHolder> holder(new XDisplayHolder(display, closeDisplay));
    reason = format("the X server at DISPLAY %s has no GLX that draws in colour and depth", name);
    int opcode, event, error, n = 0;
    if (!queryExtension(display, "GLX", &opcode, &event, &error)) return Ptr<XDisplayHolder>();
    void* glx = dlopen("libGLX.so.0", RTLD_LAZY | RTLD_LOCAL);
    if (!glx) glx = dlopen("libGL.so.1", RTLD_LAZY | RTLD_LOCAL);
    void** (*chooseConfig)(void*, int, const int*, int*);
    void* (*getVisual)(void*, void*);
    if (!load(defaultScreen, x11, "XDefaultScreen") || !load(release, x11, "XFree") || !load(chooseConfig, glx, "glXChooseFBConfig")
        || !load(getVisual, glx, "glXGetVisualFromFBConfig"))
        return Ptr<XDisplayHolder>();
    const int wanted[] = {GLX_RED_SIZE, 8, GLX_GREEN_SIZE, 8, GLX_BLUE_SIZE, 8, GLX_DEPTH_SIZE, 1, 0};
    void** configs = chooseConfig(display, defaultScreen(display), wanted, &n);
    void* visual = configs && n > 0 ? getVisual(display, configs[0]) : 0;
    if (configs) release(configs);
    if (!visual) return Ptr<XDisplayHolder>();
    release(visual);
    return holder;
}

#endif

}} // namespace cv::surgtrack
