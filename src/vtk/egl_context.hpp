// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_VTK_EGL_CONTEXT_HPP
#define OPENCV_SURGTRACK_SRC_VTK_EGL_CONTEXT_HPP

#include "opencv2/core.hpp"

// OpenGL contexts without a window. libEGL, libGLX and libX11 are opened at run time: none of them is needed to build the
// module, or to load it.

namespace cv { namespace surgtrack {

/** @brief An OpenGL 3.2 core context that needs no X server, no window and no surface. */
class EGLContextHolder
{
public:
    /** @param reason why there is none, if the result is empty */
    static Ptr<EGLContextHolder> create(String& reason);
    ~EGLContextHolder();

    bool makeCurrent() const;
    bool isCurrent() const;

private:
    struct Library;
    EGLContextHolder(const Ptr<Library>& library, void* display, void* context);
    EGLContextHolder(const EGLContextHolder&);
    EGLContextHolder& operator=(const EGLContextHolder&);

    Ptr<Library> egl_;
    void* display_;
    void* context_;
};

/** @brief Sets aside the contexts, of GLX and EGL, that are current in this thread, and brings them back at the end. */
class SavedGLContexts
{
public:
    SavedGLContexts();
    ~SavedGLContexts();

private:
    SavedGLContexts(const SavedGLContexts&);
    SavedGLContexts& operator=(const SavedGLContexts&);
    void release();

    struct GLX
    {
        void* (*getCurrentContext)();
        void* (*getCurrentDisplay)();
        unsigned long (*getCurrentDrawable)();
        unsigned long (*getCurrentReadDrawable)();
        int (*makeContextCurrent)(void*, unsigned long, unsigned long, void*);
        void *context, *display;
        unsigned long draw, read;
    } glx_;
    struct EGL
    {
        void* (*getCurrentContext)();
        void* (*getCurrentDisplay)();
        void* (*getCurrentSurface)(int);
        unsigned (*makeCurrent)(void*, void*, void*, void*);
        unsigned (*queryAPI)();
        unsigned (*bindAPI)(unsigned);
        void *context, *display, *draw, *read;
        unsigned api;
    } egl_;
};

/** @brief A connection to an X server that speaks GLX. */
class XDisplayHolder
{
public:
    /** @param reason why there is none, if the result is empty */
    static Ptr<XDisplayHolder> create(String& reason);
    ~XDisplayHolder();

    void* const display;

    /** @brief While it lives, errors the X server reports are passed over: by default they end the process. */
    class ErrorsIgnored
    {
    public:
        ErrorsIgnored();
        ~ErrorsIgnored();

    private:
        void* was_;
    };

private:
    XDisplayHolder(void* newDisplay, int (*close)(void*)) : display(newDisplay), close_(close) {}
    XDisplayHolder(const XDisplayHolder&);
    XDisplayHolder& operator=(const XDisplayHolder&);

    int (*close_)(void*);
};

}} // namespace cv::surgtrack

#endif
