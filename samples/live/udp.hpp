// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// UDP over IPv4, by POSIX sockets; on Windows the constructors say that there is none.

#ifndef OPENCV_SURGTRACK_SAMPLES_LIVE_UDP_HPP
#define OPENCV_SURGTRACK_SAMPLES_LIVE_UDP_HPP

#include <string>
#include <vector>
#ifndef _WIN32
#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#endif
#include "../support/common.hpp"

namespace common {

#ifndef _WIN32

//! An address of IPv4 as sockets have it. @param argument that has it, for the error
inline in_addr addressOf(const std::string& text, const char* argument)
{
    in_addr address = {};
    if (::inet_pton(AF_INET, text.c_str(), &address) != 1)
        fail(std::string("argument '") + argument + "=" + text + "': expected an address such as 192.168.0.5");
    return address;
}

//! Takes in packets that are sent to any of some ports.
class UdpReceiver
{
public:
    //! @param listen address of this machine that packets come to; 0.0.0.0: any @param from whom packets are taken from; empty: anyone
    UdpReceiver(const std::vector<int>& ports, const std::string& listen, const std::string& from)
        : buffer_(65536), last_(0), fromAll_(from.empty()), from_(fromAll_ ? in_addr() : addressOf(from, "--from"))
    {
        const in_addr own = addressOf(listen, "--listen");
        for (size_t i = 0; i < ports.size(); i++)
        {
            const pollfd entry = { ::socket(AF_INET, SOCK_DGRAM, 0), POLLIN, 0 };
            sockets_.push_back(entry);
            sockaddr_in address = {};
            address.sin_family = AF_INET;
            address.sin_port = htons((uint16_t)ports[i]);
            address.sin_addr = own;
            const int room = 1 << 20;   // some hundred packets: none is lost while the system is busy
            setsockopt(entry.fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof(room));
            if (entry.fd >= 0 && ::bind(entry.fd, (const sockaddr*)&address, sizeof(address)) == 0)
                continue;
            const std::string reason = std::strerror(errno);
            close();
            fail(cv::format("UDP port %d of %s can't be listened on: %s", ports[i], listen.c_str(), reason.c_str()));
        }
    }
    ~UdpReceiver() { close(); }
    UdpReceiver(const UdpReceiver&) = delete;
    UdpReceiver& operator=(const UdpReceiver&) = delete;

    //! Waits for a packet, up to so many milliseconds. port: index of the one it came by. Those of others than `from` are let go.
    bool receive(std::string& packet, int& port, int milliseconds)
    {
        if (::poll(sockets_.data(), (nfds_t)sockets_.size(), milliseconds) <= 0)
            return false;
        for (size_t k = 1; k <= sockets_.size(); k++)
        {
            const size_t i = (last_ + k) % sockets_.size();    // in turn: a flood on one port must not silence another
            if (!sockets_[i].revents)
                continue;
            sockaddr_in sender = {};
            socklen_t length = sizeof(sender);
            const ssize_t size = ::recvfrom(sockets_[i].fd, buffer_.data(), buffer_.size(), MSG_DONTWAIT, (sockaddr*)&sender, &length);
            if (size < 0 || (!fromAll_ && sender.sin_addr.s_addr != from_.s_addr))
                continue;
            packet.assign(buffer_.data(), (size_t)size);
            port = (int)i;
            last_ = i;
            return true;
        }
        return false;
    }

private:
    void close()
    {
        for (size_t i = 0; i < sockets_.size(); i++)
            if (sockets_[i].fd >= 0) ::close(sockets_[i].fd);
    }

    std::vector<pollfd> sockets_;
    std::vector<char> buffer_;
    size_t last_;    // index of the port the last packet came by
    bool fromAll_;
    in_addr from_;
};

//! Sends packets to one place. That nobody listens there is no error.
class UdpSender
{
public:
    //! @param place HOST:PORT
    explicit UdpSender(const std::string& place) : socket_(-1)
    {
        const size_t colon = place.rfind(':');
        const std::string host = place.substr(0, colon), port = colon == std::string::npos ? "" : place.substr(colon + 1);
        addrinfo hints = {}, *found = 0;
        hints.ai_family = AF_INET;
        hints.ai_socktype = SOCK_DGRAM;
        hints.ai_flags = AI_NUMERICSERV;
        if (host.empty() || port.empty() || ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0)
            fail("'" + place + "' is no place to send to, expected HOST:PORT, such as 127.0.0.1:48060");
        socket_ = ::socket(AF_INET, SOCK_DGRAM, 0);
        const bool connected = socket_ >= 0 && ::connect(socket_, found->ai_addr, found->ai_addrlen) == 0;
        const std::string reason = std::strerror(errno);
        ::freeaddrinfo(found);
        if (connected)
            return;
        if (socket_ >= 0) ::close(socket_);
        fail(place + " can't be sent to: " + reason);
    }
    ~UdpSender() { ::close(socket_); }
    UdpSender(const UdpSender&) = delete;
    UdpSender& operator=(const UdpSender&) = delete;

    //! Never waits. Whether the system took the packet; not whether it arrived.
    bool send(const std::string& packet) { return ::send(socket_, packet.data(), packet.size(), MSG_DONTWAIT) == (ssize_t)packet.size(); }

private:
    int socket_;
};

#else

class UdpReceiver
{
public:
    UdpReceiver(const std::vector<int>&, const std::string&, const std::string&) { fail("UDP needs POSIX sockets, which this system lacks"); }
    bool receive(std::string&, int&, int) { return false; }
};

class UdpSender
{
public:
    explicit UdpSender(const std::string&) { fail("UDP needs POSIX sockets, which this system lacks"); }
    bool send(const std::string&) { return false; }
};

#endif

} // namespace common

#endif
